#include "exterior/orient_photo.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "core/base/chi_square.h"
#include "core/base/side_by_side.h"
#include "exterior/judge.h"
#include "exterior/search/first_pose.h"
#include "exterior/search/wide_search.h"
#include "exterior/steps/align.h"
#include "exterior/steps/consensus.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/match.h"
#include "exterior/steps/patch_observation.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/predict.h"
#include "exterior/steps/resect.h"

namespace orient::exterior {
namespace {

constexpr int kMaxPreciseRounds = 5;
constexpr int kPrecisePatches = 900;  // at full resolution

const double kPriorChi2Limit = ChiSquareLimit(6, 1e-4);

// One round at full resolution.
struct PreciseRound {
  std::vector<PatchPrediction> predictions;
  std::vector<UnseenPatch> not_visible;
  std::vector<PreciseMatch> matches;     // one a prediction
  std::vector<std::size_t> observed;     // the predictions that were found
  std::optional<PoseEstimate> estimate;  // over the observed
  bool contradicts_prior = false;        // the estimate then does without it
  double window_px = 0;
  double mean_window_px2 = 0;
};

PreciseRound MatchAll(const PhotoTask& task, const PhotoView& view, const Matrix6d& covariance,
                      double margin_px) {
  PreciseRound round;
  const auto visible =
      Predict(view, covariance, task.patches, task.Prediction(), &round.not_visible);
  round.predictions = SelectSpread(visible, task.patches, kPrecisePatches, task.Prediction());
  round.matches.resize(round.predictions.size());
  std::vector<double> areas(round.predictions.size(), 0);
  PreciseOptions options;
  const auto match = [&](std::size_t i) {
    const PatchPrediction& prediction = round.predictions[i];
    const Eigen::Vector2d radius =
        prediction.Radius(kWindowSigmas) + Eigen::Vector2d::Constant(margin_px);
    areas[i] = AreaToSearch(prediction.pixel, radius, task.image).Size().prod();
    const auto aligned =
        AlignPatch(view, task.patches[prediction.patch], 1, kMinSide_px, kMaxSide_px);
    if (aligned)
      round.matches[i] = MatchPrecisely(*aligned, task.image, radius, options);
    else
      round.matches[i].why_not = {{.reason = Reason::kPatchTooSmall}};
  };
  SideBySide(round.predictions.size(), match);
  // Another season, film or decade: where grey values find few, gradients are worth their cost and
  // their lesser precision.
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < round.matches.size(); ++i)
    if (!round.matches[i].found) missing.push_back(i);
  if (2 * missing.size() > round.matches.size()) {
    options.gradients = true;
    SideBySide(missing.size(), [&](std::size_t i) { match(missing[i]); });
  }
  round.window_px = LargestRadius(round.predictions, kWindowSigmas) + margin_px;
  for (const double area : areas)
    round.mean_window_px2 += area / static_cast<double>(std::max<std::size_t>(areas.size(), 1));
  return round;
}

void Resect(const PhotoTask& task, const PoseTrack& track, const PhotoView& view,
            PreciseRound* round) {
  std::vector<PatchObservation> observations;
  for (std::size_t i = 0; i < round->matches.size(); ++i) {
    if (!round->matches[i].found) continue;
    const PatchPrediction& prediction = round->predictions[i];
    round->observed.push_back(i);
    const PreciseMatch& match = round->matches[i];
    observations.push_back(
        ObservationOf(task.patches[prediction.patch], match.pixel, match.covariance_px2, view));
  }
  if (observations.empty()) return;
  const CommonErrors common =
      CommonErrorsOf(track.position, view, observations.front().ground_m.z());
  round->estimate = EstimatePose(view, task.photo.prior, observations, common);
  if (round->estimate && round->estimate->prior_chi2 <= kPriorChi2Limit) return;
  // Against a prior that is far off there may be no solution at all.
  round->estimate = EstimatePose(view, Weakened(task.photo.prior), observations, common);
  if (!round->estimate) return;
  const PosePrior& prior = task.photo.prior;
  const Vector6d off = PoseDifference(round->estimate->pose, prior.pose);
  round->estimate->prior_chi2 = off.dot(prior.covariance.ldlt().solve(off));
  round->contradicts_prior = round->estimate->prior_chi2 > kPriorChi2Limit;
}

double RmsPx(const PoseEstimate& estimate) {
  double sum = 0;
  for (std::size_t i = 0; i < estimate.residuals_px.size(); ++i)
    if (!estimate.rejected[i]) sum += estimate.residuals_px[i].squaredNorm();
  return std::sqrt(sum / std::max(estimate.used, 1));
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

// Rounds at full resolution until nothing more is won; the last one is the result. Empty: too few
// patches could be matched.
std::vector<PreciseRound> Refine(const PhotoTask& task, PoseTrack* track) {
  std::vector<PreciseRound> rounds;
  double margin = 2.0 * track->reduction + 4;
  for (int i = 0; i < kMaxPreciseRounds; ++i) {
    const PhotoView view = task.View(track->position, track->pose);
    PreciseRound round = MatchAll(task, view, track->covariance, margin);
    Resect(task, *track, view, &round);
    if (!round.estimate) break;
    const double moved_px = LargestMove(task, view, round);
    track->rounds.push_back({static_cast<int>(round.predictions.size()), round.estimate->used,
                             round.window_px, RmsPx(*round.estimate)});
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

// Patches that overlap show the same ground and are one piece of evidence: counted are the squares
// of a patch's size in which there are some.
struct Evidence {
  int sought = 0, agreeing = 0;
};

// Agrees: in this round, and still in the last one.
Evidence CountEvidence(const PreciseRound& round, const PreciseRound& last) {
  std::set<std::size_t> at_last;
  for (std::size_t k = 0; k < last.observed.size(); ++k)
    if (!last.estimate->rejected[k]) at_last.insert(last.predictions[last.observed[k]].patch);
  std::map<std::pair<long, long>, bool> squares;
  const auto square = [&](const PatchPrediction& prediction) -> bool& {
    const Eigen::Vector2d place = prediction.pixel / kMaxSide_px;
    return squares[{std::lround(std::floor(place.x())), std::lround(std::floor(place.y()))}];
  };
  for (const PatchPrediction& prediction : round.predictions) square(prediction);
  for (std::size_t k = 0; k < round.observed.size(); ++k) {
    const PatchPrediction& prediction = round.predictions[round.observed[k]];
    if (!round.estimate->rejected[k] && at_last.count(prediction.patch) > 0)
      square(prediction) = true;
  }
  Evidence evidence{static_cast<int>(squares.size()), 0};
  for (const auto& [place, agrees] : squares) evidence.agreeing += agrees ? 1 : 0;
  return evidence;
}

// Whether chance could have led from random matches to this round's supporters: each has what area
// gross errors pass in, or that of three sigma where residuals say that it ought to be larger.
double PreciseFalseAlarms(const PreciseRound& round, const Evidence& evidence) {
  const double reach = 3 * std::max(round.estimate->sigma0_px, 0.2);
  const double area = std::max(std::numbers::pi * reach * reach, round.estimate->passing_px2);
  const double in_a_square =
      static_cast<double>(round.predictions.size()) / std::max(evidence.sought, 1);
  const double p = std::min(1.0, in_a_square * area / round.mean_window_px2);
  return Log10FalseAlarms(evidence.sought, evidence.agreeing, in_a_square, p);
}

// Of the round that proves most: usually the first, whose windows are the largest. Where patches
// were found there the others only look again.
double LeastFalseAlarms(const std::vector<PreciseRound>& rounds) {
  double least = 0;
  for (const PreciseRound& round : rounds)
    least = std::min(least, PreciseFalseAlarms(round, CountEvidence(round, rounds.back())));
  return least + std::log10(static_cast<double>(rounds.size()));
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

JudgedPose ToJudge(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                   const PoseTrack& track) {
  const PreciseRound& round = rounds.back();
  const PoseEstimate& estimate = *round.estimate;
  double height = 0;
  for (const PatchPrediction& p : round.predictions)
    height += task.patches[p.patch].ground_m.z() / static_cast<double>(round.predictions.size());
  JudgedPose judged;
  judged.sought = static_cast<int>(round.predictions.size());
  judged.matched = static_cast<int>(round.observed.size());
  judged.agreeing = estimate.used;
  judged.places = CountEvidence(round, round).agreeing;
  judged.log10_false_alarms = LeastFalseAlarms(rounds);
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

  std::optional<PoseTrack> track = options.wide ? SearchWidely(task) : FirstPose(task);
  if (!track) return Failed(photo, options.wide ? NothingAlike() : WhyNoFirstPose(task), nullptr);
  const auto chance = [&] { return track->log10_false_alarms > options.max_log10_false_alarms; };
  const auto no_consensus = [&] {
    return Failed(photo, NoConsensus(track->rounds.front(), options.wide), &*track);
  };
  // What a wide search leaves open at its level, patches may show at a finer one.
  if (!options.wide && chance()) return no_consensus();
  Descend(task, &*track);
  if (chance()) return no_consensus();
  const std::vector<PreciseRound> rounds = Refine(task, &*track);
  if (rounds.empty()) return Failed(photo, TooFewPreciseMatches(), &*track);
  const PreciseRound& round = rounds.back();
  const JudgedPose judged = ToJudge(task, rounds, *track);
  if (const auto objection = WhyNotAccepted(judged, options))
    return Failed(photo, *objection, &*track);

  ExteriorResult result;
  result.photo = photo.name;
  result.pose = round.estimate->pose;
  result.covariance = round.estimate->honest_covariance;
  result.sigma0_px = round.estimate->sigma0_px;
  result.orientation = track->position.orientation;
  result.iterations = track->rounds;
  FillPatches(task, round, &result);
  result.findings = Judge(judged);
  result.status = StatusOf(result.findings);
  return result;
}

}  // namespace orient::exterior
