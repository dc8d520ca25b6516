#include "exterior/steps/precise_round.h"

#include <Eigen/Dense>
#include <algorithm>
#include <functional>

#include "core/base/chi_square.h"
#include "core/base/side_by_side.h"
#include "exterior/steps/align.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/patch_observation.h"

namespace orient::exterior {
namespace {

constexpr int kPrecisePatches = 900;
constexpr std::size_t kDecoys = 200;  // of either kind, at most

const double kPriorChi2Limit = ChiSquareLimit(6, 1e-4);

Eigen::Vector2d WindowRadius(const PatchPrediction& prediction, double margin_px) {
  return prediction.Radius(kWindowSigmas) + Eigen::Vector2d::Constant(margin_px);
}

// How a patch looks under the view; empty where it is too small there.
std::optional<AlignedPatch> Drawn(const PhotoTask& task, const PhotoView& view,
                                  const PatchPrediction& prediction) {
  return AlignPatch(view, task.patches[prediction.patch], 1, kMinSide_px, kMaxSide_px);
}

using Drawing = std::function<std::optional<AlignedPatch>(std::size_t)>;

// What is drawn, around the predictions. Another season, film or decade: where grey values find
// few, gradients are worth their cost and their lesser precision. Says whether they were asked.
bool MatchDrawn(const PhotoTask& task, const PreciseRound& round,
                const std::vector<std::size_t>& which, const Drawing& drawing,
                std::vector<PreciseMatch>* matches) {
  PreciseOptions options;
  matches->resize(which.size());
  const auto match = [&](std::size_t i) {
    const PatchPrediction& prediction = round.predictions[which[i]];
    if (const auto drawn = drawing(which[i]))
      (*matches)[i] =
          MatchPrecisely(*drawn, task.image, WindowRadius(prediction, round.margin_px), options);
    else
      (*matches)[i].why_not = {{.reason = Reason::kPatchTooSmall}};
  };
  SideBySide(which.size(), match);
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < matches->size(); ++i)
    if (!(*matches)[i].found) missing.push_back(i);
  options.gradients = round.by_gradients || 2 * missing.size() > matches->size();
  if (options.gradients) SideBySide(missing.size(), [&](std::size_t i) { match(missing[i]); });
  return options.gradients;
}

AlignedPatch Mirrored(AlignedPatch patch) {
  for (int row = 0; row < patch.image.height; ++row)
    std::reverse(patch.image.Row(row), patch.image.Row(row) + patch.image.width);
  return patch;
}

}  // namespace

PreciseRound MatchAll(const PhotoTask& task, const PhotoView& view, const Matrix6d& covariance,
                      double margin_px) {
  PreciseRound round;
  round.view = view;
  round.margin_px = margin_px;
  const auto visible =
      Predict(view, covariance, task.patches, task.Prediction(), &round.not_visible);
  round.predictions = SelectSpread(visible, task.patches, kPrecisePatches, task.Prediction());
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < round.predictions.size(); ++i) {
    const PatchPrediction& prediction = round.predictions[i];
    const auto area =
        AreaToSearch(prediction.pixel, WindowRadius(prediction, margin_px), task.image);
    round.mean_window_px2 += area.Size().prod() / static_cast<double>(round.predictions.size());
    all.push_back(i);
  }
  round.window_px = LargestRadius(round.predictions, kWindowSigmas) + margin_px;
  round.by_gradients = MatchDrawn(
      task, round, all, [&](std::size_t i) { return Drawn(task, view, round.predictions[i]); },
      &round.matches);
  return round;
}

void Resect(const PhotoTask& task, const PoseTrack& track, PreciseRound* round) {
  std::vector<PatchObservation> observations;
  for (std::size_t i = 0; i < round->matches.size(); ++i) {
    if (!round->matches[i].found) continue;
    const PatchPrediction& prediction = round->predictions[i];
    round->observed.push_back(i);
    const PreciseMatch& match = round->matches[i];
    observations.push_back(ObservationOf(task.patches[prediction.patch], match.pixel,
                                         match.covariance_px2, round->view));
  }
  if (observations.empty()) return;
  const CommonErrors common =
      CommonErrorsOf(track.position, round->view, observations.front().ground_m.z());
  round->estimate = EstimatePose(round->view, task.photo.prior, observations, common);
  if (round->estimate && round->estimate->prior_chi2 <= kPriorChi2Limit) return;
  // Against a prior that is far off there may be no solution at all.
  round->estimate = EstimatePose(round->view, Weakened(task.photo.prior), observations, common);
  if (!round->estimate) return;
  const PosePrior& prior = task.photo.prior;
  const Vector6d off = PoseDifference(round->estimate->pose, prior.pose);
  round->estimate->prior_chi2 = off.dot(prior.covariance.ldlt().solve(off));
  round->contradicts_prior = round->estimate->prior_chi2 > kPriorChi2Limit;
}

DecoyMatches MatchDecoys(const PhotoTask& task, const PreciseRound& round) {
  const std::vector<PatchPrediction>& predictions = round.predictions;
  std::vector<std::size_t> which;
  const std::size_t step = 1 + (predictions.size() - 1) / kDecoys;
  for (std::size_t i = 0; i < predictions.size(); i += step) which.push_back(i);
  const auto mirrored = [&](std::size_t i) -> std::optional<AlignedPatch> {
    auto drawn = Drawn(task, round.view, predictions[i]);
    if (drawn) drawn = Mirrored(std::move(*drawn));
    return drawn;
  };
  const auto exchanged = [&](std::size_t i) -> std::optional<AlignedPatch> {
    const std::size_t other = (i + predictions.size() / 2) % predictions.size();
    const auto here = Drawn(task, round.view, predictions[i]);
    auto drawn = Drawn(task, round.view, predictions[other]);
    if (here && drawn) drawn->predicted_px = here->predicted_px;
    return here ? drawn : std::nullopt;
  };
  DecoyMatches most;
  for (const Drawing& drawing : {Drawing(mirrored), Drawing(exchanged)}) {
    std::vector<PreciseMatch> matches;
    MatchDrawn(task, round, which, drawing, &matches);
    const auto found = std::count_if(matches.begin(), matches.end(),
                                     [](const PreciseMatch& match) { return match.found; });
    most = {static_cast<int>(which.size()), std::max(most.found, static_cast<int>(found))};
  }
  return most;
}

}  // namespace orient::exterior
