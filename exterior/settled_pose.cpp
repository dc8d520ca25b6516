#include "exterior/settled_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

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

// `again`: not for the first time; then chance must be as rare as if nothing had been proven yet.
JudgedMatches ToJudge(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                      const PoseTrack& track, bool again) {
  const PreciseRound& round = rounds.back();
  JudgedMatches judged;
  judged.sought = static_cast<int>(round.predictions.size());
  judged.matched = static_cast<int>(round.observed.size());
  judged.agreeing = round.estimate->used;
  judged.places = CountEvidence(round, round).agreeing;
  const bool proven = track.log10_false_alarms <= task.options.max_log10_false_alarms;
  judged.proven_before = proven && !again;
  const double ways = proven ? 0 : std::log10(track.trials);
  const double enough = FalseAlarmLimit(judged.proven_before, task.options);
  judged.log10_false_alarms = ways + LeastFalseAlarms(task, rounds, enough - ways);
  return judged;
}

SettledPose Settle(const PhotoTask& task, PoseTrack track, int reduction, bool again) {
  SettledPose pose{std::move(track), {}, {}, {}};
  pose.rounds = Refine(task, reduction, &pose.track);
  const PreciseRound& last = pose.Last();
  if (!last.estimate) {
    pose.why_not = NoPreciseResection(static_cast<int>(last.observed.size()),
                                      static_cast<int>(last.predictions.size()));
    return pose;
  }
  pose.matches = ToJudge(task, pose.rounds, pose.track, again);
  pose.why_not = WhyNotAccepted(pose.matches, task.options);
  return pose;
}

// Whether so few patches agree that grain may hide the others, or what a refused pose lacks. It
// does not explain that matches contradict the pose.
bool MayBeGrain(const SettledPose& pose) {
  constexpr double kFew = 0.25;  // share of the patches sought
  if (!pose.why_not) return pose.matches.agreeing < kFew * pose.matches.sought;
  const Reason reason = pose.why_not->reason;
  return reason == Reason::kTooFewPreciseMatches || reason == Reason::kTooFewAgree ||
         reason == Reason::kAgreementMayBeChance;
}

double WorstSigma(const PhotoTask& task, const SettledPose& pose) {
  const PreciseRound& round = pose.Last();
  return WorstProjectionSigma(round.view, round.estimate->honest_covariance,
                              MeanHeight(task, round));
}

// At lower resolutions less of a film's grain is left, and more patches match, each less precisely:
// the pose from the resolution at which it is accepted and most precise, or else as refused.
SettledPose SettleCoarsely(const PhotoTask& task, const PoseTrack& track, SettledPose pose) {
  for (int reduction = 2 * pose.Last().reduction; reduction <= kMostReduction && MayBeGrain(pose);
       reduction *= 2) {
    SettledPose coarser = Settle(task, track, reduction, true);
    if (!coarser.why_not && (pose.why_not || WorstSigma(task, coarser) < WorstSigma(task, pose)))
      pose = std::move(coarser);
    else if (!pose.why_not)
      break;
  }
  return pose;
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
  found.matches = ToJudge(task, found.rounds, found.track, false);
  found.why_not = WhyNotAccepted(found.matches, task.options);
  if (found.why_not) return std::nullopt;
  return found;
}

}  // namespace

SettledPose SettlePose(const PhotoTask& task, const PoseTrack& track, int reduction) {
  SettledPose pose = Settle(task, track, reduction, false);
  const bool proven = track.log10_false_alarms <= task.options.max_log10_false_alarms;
  if (proven) pose = SettleCoarsely(task, track, std::move(pose));
  if (pose.why_not || task.options.wide || !MayBeARepetition(pose)) return pose;
  const PreciseRound& settled = pose.Last();
  auto beyond = FoundBeyond(task, settled.reduction, settled.estimate->prior_chi2 > kChi2AtEdge);
  return beyond && beyond->matches.agreeing > pose.matches.agreeing ? *std::move(beyond) : pose;
}

double MeanHeight(const PhotoTask& task, const PreciseRound& round) {
  double sum = 0;
  for (const PatchPrediction& p : round.predictions) sum += task.patches[p.patch].ground_m.z();
  return sum / static_cast<double>(round.predictions.size());
}

LoopRound SummaryOf(const PreciseRound& round) {
  return {static_cast<int>(round.predictions.size()), round.estimate->used, round.window_px,
          RmsPx(*round.estimate), round.reduction};
}

}  // namespace orient::exterior
