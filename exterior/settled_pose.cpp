#include "exterior/settled_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/terrain/pixel_derivatives.h"
#include "exterior/search/first_pose.h"
#include "exterior/steps/evidence.h"

namespace orient::exterior {
namespace {

constexpr int kMaxPreciseRounds = 5;
// With no more distortion than this, in pixels of the reduction, patches drawn anew would match
// where they did before.
constexpr double kSettled_px = 0.1;
// On repetitive ground many patches also match beside their true place, but less well. If no larger
// a share agrees, and no better, the pose is compared with one easily found beyond the search
// windows, for at the true pose nearly all patches match; at the edge of what the approximation
// allows, with any pose found there.
constexpr double kShareBeyondDoubt = 0.67;  // share of the patches sought that agree
constexpr double kRmsBeyondDoubt_px = 0.5;  // of the reduction
constexpr double kChi2AtEdge = 10.6;  // 6 degrees of freedom: one correct approximation in ten
constexpr double kTimesStated = 4;    // factor on the stated sigmas

double RmsPx(const PoseEstimate& estimate) {
  double sum = 0;
  for (std::size_t i = 0; i < estimate.residuals_px.size(); ++i)
    if (!estimate.rejected[i]) sum += estimate.residuals_px[i].squaredNorm();
  return std::sqrt(sum / std::max(estimate.used, 1));
}

// Largest distortion of a patch, scan pixels, between the view it was drawn under and the round's
// pose: displacement of its edges against its middle, as a mere shift does not distort it.
double LargestDistortion(const PhotoTask& task, const PreciseRound& round) {
  const double edge_px = kMaxSide_px * round.reduction / 2.0;
  PhotoView after = round.view;
  after.pose = round.estimate->pose;
  double largest = 0;
  for (const PatchPrediction& prediction : round.predictions) {
    const Eigen::Vector3d& ground_m = task.patches[prediction.patch].ground_m;
    const auto drawn = PixelFromGroundWithDerivatives(round.view, ground_m);
    const auto now = PixelFromGroundWithDerivatives(after, ground_m);
    if (!drawn || !now) continue;
    const Eigen::Matrix2d change =
        now->by_ground.leftCols<2>() * drawn->by_ground.leftCols<2>().inverse() -
        Eigen::Matrix2d::Identity();
    largest = std::max(largest, edge_px * change.norm());
  }
  return largest;
}

// Precise rounds until another would gain nothing; the last one is the result. If the first one has
// no estimate, there is no pose.
std::vector<PreciseRound> Refine(const PhotoTask& task, int reduction, PoseTrack* track) {
  std::vector<PreciseRound> rounds;
  constexpr double kMargin_px = 4;
  double margin_px = 2.0 * track->reduction / reduction + kMargin_px;
  for (int i = 0; i < kMaxPreciseRounds; ++i) {
    const PhotoView view = task.View(track->position, track->pose);
    PreciseRound round = MatchAll(task, view, track->covariance, margin_px, reduction);
    Resect(task, *track, &round);
    if (!round.estimate) {
      if (rounds.empty()) rounds.push_back(std::move(round));
      break;
    }
    const double distorted_px = LargestDistortion(task, round);
    track->rounds.push_back(SummaryOf(round));
    track->pose = round.estimate->pose;
    track->covariance = round.estimate->covariance;
    rounds.push_back(std::move(round));
    if (distorted_px < kSettled_px * reduction) break;
    margin_px = kMargin_px;
  }
  return rounds;
}

JudgedMatches ToJudge(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                      const PoseTrack& track) {
  const PreciseRound& round = rounds.back();
  JudgedMatches judged;
  judged.sought = static_cast<int>(round.predictions.size());
  judged.matched = static_cast<int>(round.observed.size());
  judged.agreeing = round.estimate->used;
  judged.places = CountEvidence(round, round).agreeing;
  judged.proven_before = track.log10_false_alarms <= task.options.max_log10_false_alarms;
  const double ways = judged.proven_before ? 0 : std::log10(track.trials);
  const double enough = FalseAlarmLimit(judged.proven_before, task.options);
  judged.log10_false_alarms = ways + LeastFalseAlarms(task, rounds, enough - ways);
  return judged;
}

bool MayBeARepetition(const SettledPose& pose) {
  return pose.matches.agreeing < kShareBeyondDoubt * pose.matches.sought &&
         RmsPx(*pose.Last().estimate) > kRmsBeyondDoubt_px * pose.Last().reduction;
}

// The pose found if the approximation's sigmas are taken to be several times the stated ones, but
// judged against the approximation as stated; empty if it would not be accepted.
std::optional<SettledPose> FoundBeyond(const PhotoTask& task, int reduction, bool at_edge) {
  PhotoToOrient photo = task.photo;
  photo.prior.covariance *= kTimesStated * kTimesStated;
  const PhotoTask beyond{photo, task.image, task.patches, task.options};
  auto track = at_edge ? FirstPose(beyond) : EasyFirstPose(beyond);
  if (!track || track->log10_false_alarms > task.options.max_log10_false_alarms)
    return std::nullopt;
  SettledPose found{*std::move(track), {}, {}, {}};
  Descend(beyond, reduction, &found.track);
  if (found.track.log10_false_alarms > task.options.max_log10_false_alarms) return std::nullopt;
  found.rounds = Refine(beyond, reduction, &found.track);
  if (!found.Last().estimate) return std::nullopt;
  Resect(task, found.track, &found.rounds.back());
  if (!found.Last().estimate) return std::nullopt;
  found.matches = ToJudge(task, found.rounds, found.track);
  found.why_not = WhyNotAccepted(found.matches, task.options);
  if (found.why_not) return std::nullopt;
  return found;
}

}  // namespace

SettledPose SettlePose(const PhotoTask& task, const PoseTrack& track, int reduction) {
  SettledPose pose{track, {}, {}, {}};
  pose.rounds = Refine(task, reduction, &pose.track);
  const PreciseRound& settled = pose.Last();
  if (!settled.estimate) {
    pose.why_not = NoPreciseResection(static_cast<int>(settled.observed.size()),
                                      static_cast<int>(settled.predictions.size()));
    return pose;
  }
  pose.matches = ToJudge(task, pose.rounds, pose.track);
  pose.why_not = WhyNotAccepted(pose.matches, task.options);
  if (pose.why_not || task.options.wide || !MayBeARepetition(pose)) return pose;
  auto beyond = FoundBeyond(task, reduction, settled.estimate->prior_chi2 > kChi2AtEdge);
  if (beyond && beyond->matches.agreeing > pose.matches.agreeing) return *std::move(beyond);
  return pose;
}

LoopRound SummaryOf(const PreciseRound& round) {
  return {static_cast<int>(round.predictions.size()), round.estimate->used, round.window_px,
          RmsPx(*round.estimate), round.reduction};
}

}  // namespace orient::exterior
