#include "exterior/orient_photo.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "exterior/judge.h"
#include "exterior/search/first_pose.h"
#include "exterior/search/wide_search.h"
#include "exterior/steps/evidence.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/precise_round.h"

namespace orient::exterior {
namespace {

constexpr int kMaxPreciseRounds = 5;
// The best pose of a search of the whole photo is judged at full resolution if chance explains it
// less often than this; the ways tried then count against it.
constexpr double kWorthAJudgement = -1;

double RmsPx(const PoseEstimate& estimate) {
  double sum = 0;
  for (std::size_t i = 0; i < estimate.residuals_px.size(); ++i)
    if (!estimate.rejected[i]) sum += estimate.residuals_px[i].squaredNorm();
  return std::sqrt(sum / std::max(estimate.used, 1));
}

LoopRound Told(const PreciseRound& round) {
  return {static_cast<int>(round.predictions.size()), round.estimate->used, round.window_px,
          RmsPx(*round.estimate)};
}

// How far a round's pose moves the patches from where the pose before it saw them.
double LargestMove(const PhotoTask& task, const PhotoView& before, const PreciseRound& round) {
  PhotoView after = before;
  after.pose = round.estimate->pose;
  double largest = 0;
  for (const PatchPrediction& prediction : round.predictions)
    if (const auto pixel = after.PixelFromGround(task.patches[prediction.patch].ground_m))
      largest = std::max(largest, (*pixel - prediction.pixel).norm());
  return largest;
}

constexpr double kSettledPx = 0.5;

// Rounds at full resolution until nothing more is won; the last one is the result. The first one
// without an estimate: no pose.
std::vector<PreciseRound> Refine(const PhotoTask& task, PoseTrack* track) {
  std::vector<PreciseRound> rounds;
  double margin = 2.0 * track->reduction + 4;
  for (int i = 0; i < kMaxPreciseRounds; ++i) {
    const PhotoView view = task.View(track->position, track->pose);
    PreciseRound round = MatchAll(task, view, track->covariance, margin);
    Resect(task, *track, &round);
    if (!round.estimate) {
      if (rounds.empty()) rounds.push_back(std::move(round));
      break;
    }
    const double moved_px = LargestMove(task, view, round);
    track->rounds.push_back(Told(round));
    track->pose = round.estimate->pose;
    track->covariance = round.estimate->covariance;
    rounds.push_back(std::move(round));
    // Drawn from so near a pose, every patch would match where it did.
    if (moved_px < kSettledPx) break;
    margin = 4;
  }
  return rounds;
}

void FillPatches(const PhotoTask& task, const PreciseRound& round, ExteriorResult* result) {
  std::vector<PatchResult> patches(round.predictions.size());
  for (std::size_t i = 0; i < round.predictions.size(); ++i) {
    const PreciseMatch& match = round.matches[i];
    patches[i].id = task.patches[round.predictions[i].patch].id;
    patches[i].ground_m = task.patches[round.predictions[i].patch].ground_m;
    patches[i].predicted = round.predictions[i].pixel;
    patches[i].state = PatchState::kNotFound;
    patches[i].findings = match.why_not;
  }
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    PatchResult& patch = patches[round.observed[k]];
    const PreciseMatch& match = round.matches[round.observed[k]];
    patch.state = round.estimate->rejected[k] ? PatchState::kRejected : PatchState::kMatched;
    if (round.estimate->rejected[k]) patch.findings = {{.reason = Reason::kPatchContradictsOthers}};
    patch.pixel = match.pixel;
    patch.sigma_px = match.covariance_px2.diagonal().cwiseSqrt();
    patch.residual_px = round.estimate->residuals_px[k];
    patch.ncc = match.ncc;
  }
  for (const UnseenPatch& unseen : round.not_visible) {
    PatchResult patch;
    patch.id = task.patches[unseen.patch].id;
    patch.ground_m = task.patches[unseen.patch].ground_m;
    patch.state = PatchState::kNotVisible;
    patch.findings = {{.reason = ReasonOf(unseen.why)}};
    patches.push_back(patch);
  }
  std::sort(patches.begin(), patches.end(),
            [](const PatchResult& a, const PatchResult& b) { return a.id < b.id; });
  result->patches = std::move(patches);
}

// 1: as patches all over the photo do; 0: they lie on a line.
double SpreadOf(const PhotoTask& task, const PreciseRound& round) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  double count = 0;
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    if (round.estimate->rejected[k]) continue;
    const Eigen::Vector2d& pixel = round.matches[round.observed[k]].pixel;
    sum += pixel;
    squares += pixel * pixel.transpose();
    ++count;
  }
  const Eigen::Matrix2d moments = squares / count - sum * sum.transpose() / (count * count);
  const double area = static_cast<double>(task.image.Width()) * task.image.Height();
  return 12 * std::sqrt(std::max(0.0, moments.determinant())) / area;
}

JudgedMatches ToJudge(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                      const PoseTrack& track) {
  const PreciseRound& round = rounds.back();
  JudgedMatches judged;
  judged.sought = static_cast<int>(round.predictions.size());
  judged.matched = static_cast<int>(round.observed.size());
  judged.agreeing = round.estimate->used;
  judged.places = CountEvidence(round, round).agreeing;
  const bool proven = track.log10_false_alarms <= task.options.max_log10_false_alarms;
  const double ways = proven ? 0 : std::log10(track.trials);
  judged.log10_false_alarms =
      ways + LeastFalseAlarms(task, rounds, task.options.max_log10_false_alarms - ways);
  return judged;
}

// `round`: with what was found close to the pose; `places`: without, for that assumes the pose.
JudgedPose ToJudge(const PhotoTask& task, const PreciseRound& round, int places,
                   const PoseTrack& track) {
  const PoseEstimate& estimate = *round.estimate;
  double height = 0;
  for (const PatchPrediction& p : round.predictions)
    height += task.patches[p.patch].ground_m.z() / static_cast<double>(round.predictions.size());
  JudgedPose judged;
  judged.places = places;
  judged.spread = SpreadOf(task, round);
  judged.worst_sigma_px = WorstProjectionSigma(task.View(track.position, estimate.pose),
                                               estimate.honest_covariance, height);
  judged.contradicts_prior = round.contradicts_prior;
  judged.prior_sigmas = std::sqrt(std::max(0.0, estimate.prior_chi2));
  judged.prior_counts = task.photo.accuracy_is_stated || task.options.wide;
  return judged;
}

ExteriorResult Failed(const PhotoToOrient& photo, const Finding& why, const PoseTrack* track) {
  ExteriorResult result;
  result.photo = photo.name;
  result.status = Status::kFailed;
  if (track != nullptr) result.iterations = track->rounds;
  result.findings = {why};
  return result;
}

}  // namespace

ExteriorResult OrientPhoto(const PhotoToOrient& photo, const PhotoImage& image,
                           const std::vector<patchdb::Patch>& patches,
                           const OrientPhotoOptions& options) {
  const PhotoTask task{photo, image, patches, options};
  if (patches.empty()) return Failed(photo, NoPatches("the patch database"), nullptr);

  WholePhotoSearch search;
  if (options.wide)
    search = SearchWidely(task);
  else
    search.track = FirstPose(task);
  std::optional<PoseTrack>& track = search.track;
  if (!track && options.wide)
    return Failed(photo, search.searched ? NothingAlike(search.complete) : NotSearchedAsAWhole(),
                  nullptr);
  if (!track) return Failed(photo, WhyNoFirstPose(task), nullptr);
  const auto chance = [&] { return track->log10_false_alarms > options.max_log10_false_alarms; };
  const auto no_consensus = [&] {
    return Failed(photo, NoConsensus(track->rounds.front(), options.wide, search.complete),
                  &*track);
  };
  // What a wide search leaves open at its level, patches may show at a finer one.
  if (!options.wide && chance()) return no_consensus();
  Descend(task, &*track);
  if (chance() && !(options.wide && track->log10_false_alarms < kWorthAJudgement))
    return no_consensus();
  const std::vector<PreciseRound> rounds = Refine(task, &*track);
  const PreciseRound& settled = rounds.back();
  if (!settled.estimate)
    return Failed(photo,
                  NoPreciseResection(static_cast<int>(settled.observed.size()),
                                     static_cast<int>(settled.predictions.size())),
                  &*track);
  const JudgedMatches matches = ToJudge(task, rounds, *track);
  if (const auto objection = WhyNotAccepted(matches, options))
    return Failed(photo, *objection, &*track);
  const PreciseRound round = Complete(task, *track, settled);
  track->rounds.push_back(Told(round));

  ExteriorResult result;
  result.photo = photo.name;
  result.pose = round.estimate->pose;
  result.covariance = round.estimate->honest_covariance;
  result.sigma0_px = round.estimate->sigma0_px;
  result.orientation = track->position.orientation;
  result.iterations = track->rounds;
  FillPatches(task, round, &result);
  result.findings = Judge(ToJudge(task, round, matches.places, *track));
  result.status = StatusOf(result.findings);
  return result;
}

}  // namespace orient::exterior
