#include "exterior/steps/precise_round.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "core/base/chi_square.h"
#include "core/base/side_by_side.h"
#include "core/raster/resample.h"
#include "exterior/steps/align.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/patch_observation.h"

namespace orient::exterior {
namespace {

constexpr int kPrecisePatches = 900;
constexpr double kCloseMargin_px = 1.5;  // of windows around a settled pose, beyond its sigmas
constexpr std::size_t kDecoys = 200;     // of either kind, at most

// Beyond, more patches do not make the same pose more precise, but make another one.
const double kMovedChi2Limit = ChiSquareLimit(6, 1e-3);
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
    round.windows_px2.push_back(std::max(area.Size().prod(), 1.0));
    all.push_back(i);
  }
  round.window_px = LargestRadius(round.predictions, kWindowSigmas) + margin_px;
  round.by_gradients = MatchDrawn(
      task, round, all, [&](std::size_t i) { return Drawn(task, view, round.predictions[i]); },
      &round.matches);
  return round;
}

void Resect(const PhotoTask& task, const PoseTrack& track, PreciseRound* round) {
  round->observed.clear();
  round->estimate.reset();
  round->contradicts_prior = false;
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

namespace {

using VisiblePatches = std::map<std::size_t, PatchPrediction>;  // by patch

// What is not matched, or rejected, is searched for once more close to the settled pose, which sees
// `visible`. `edges`: only what was found nowhere, and edges count across their direction.
PreciseRound Searched(const PhotoTask& task, const PoseTrack& track, const VisiblePatches& visible,
                      const PreciseRound& settled, bool edges) {
  PreciseRound round = settled;
  round.view = task.View(track.position, track.pose);
  round.margin_px = kCloseMargin_px;
  round.window_px = 0;
  std::vector<bool> stands(round.matches.size(), false);
  for (std::size_t k = 0; k < settled.observed.size(); ++k)
    stands[settled.observed[k]] = edges || !settled.estimate->rejected[k];
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const auto now = visible.find(round.predictions[i].patch);
    if (stands[i] || now == visible.end()) continue;
    round.predictions[i] = now->second;
    open.push_back(i);
    round.window_px =
        std::max(round.window_px, WindowRadius(round.predictions[i], kCloseMargin_px).maxCoeff());
  }
  // So close, a second place nearly as good says how well the patch is determined, not which it is.
  PreciseOptions close;
  close.min_score_gap = 0;
  close.edges = edges;
  SideBySide(open.size(), [&](std::size_t k) {
    const PatchPrediction& prediction = round.predictions[open[k]];
    const auto drawn = Drawn(task, round.view, prediction);
    if (!drawn) return;
    const PreciseMatch match =
        MatchPrecisely(*drawn, task.image, WindowRadius(prediction, kCloseMargin_px), close);
    if (match.found || !round.matches[open[k]].found) round.matches[open[k]] = match;
  });
  Resect(task, track, &round);
  if (!round.estimate) return settled;
  const Vector6d moved = PoseDifference(round.estimate->pose, settled.estimate->pose);
  const bool stays =
      moved.dot(settled.estimate->honest_covariance.ldlt().solve(moved)) <= kMovedChi2Limit;
  return stays ? round : settled;
}

double WorstSigma(const PhotoTask& task, const PreciseRound& round) {
  const double height_m = task.patches[round.predictions.front().patch].ground_m.z();
  return WorstProjectionSigma(round.view, round.estimate->honest_covariance, height_m);
}

}  // namespace

PreciseRound Complete(const PhotoTask& task, const PoseTrack& track, const PreciseRound& settled) {
  VisiblePatches visible;
  for (const PatchPrediction& prediction :
       Predict(task.View(track.position, track.pose), track.covariance, task.patches,
               task.Prediction()))
    visible[prediction.patch] = prediction;
  const PreciseRound points = Searched(task, track, visible, settled, false);
  const PreciseRound edges = Searched(task, track, visible, points, true);
  // Edges may err more than what they add to: of a DEM too coarse for its terrain.
  return WorstSigma(task, edges) < WorstSigma(task, points) ? edges : points;
}

Square SquareOf(const PatchPrediction& prediction) {
  const Eigen::Vector2d place = (prediction.pixel / kMaxSide_px).array().floor();
  return {std::lround(place.x()), std::lround(place.y())};
}

DecoyMatches MatchDecoys(const PhotoTask& task, const PreciseRound& round) {
  const std::vector<PatchPrediction>& predictions = round.predictions;
  std::set<Square> squares;
  std::vector<std::size_t> apart;
  for (std::size_t i = 0; i < predictions.size(); ++i)
    if (squares.insert(SquareOf(predictions[i])).second) apart.push_back(i);
  std::vector<std::size_t> which;
  const std::size_t count = std::min(apart.size(), kDecoys);
  for (std::size_t k = 0; k < count; ++k) which.push_back(apart[k * apart.size() / count]);

  const auto mirrored = [&](std::size_t i) -> std::optional<AlignedPatch> {
    auto drawn = Drawn(task, round.view, predictions[i]);
    if (drawn) drawn->image = Mirrored(std::move(drawn->image));
    return drawn;
  };
  // Few windows: several images in each.
  const std::size_t images =
      std::clamp<std::size_t>(kDecoys / std::max<std::size_t>(count, 1), 1, 4);
  const auto exchanged = [&](std::size_t i, std::size_t image) -> std::optional<AlignedPatch> {
    const std::size_t all = predictions.size(), from = i + (image + 1) * all / (images + 1);
    const Eigen::Array2d clear =
        WindowRadius(predictions[i], round.margin_px).array() + kMaxSide_px;
    for (std::size_t k = 0; k < all; ++k) {
      const PatchPrediction& other = predictions[(from + k) % all];
      if (((other.pixel - predictions[i].pixel).array().abs() <= clear).all()) continue;
      auto drawn = Drawn(task, round.view, other);
      if (drawn) drawn->predicted_px = predictions[i].pixel;
      return drawn;
    }
    return std::nullopt;
  };
  const auto add = [&](const Drawing& drawing, DecoyMatches* decoys) {
    std::vector<PreciseMatch> matches;
    MatchDrawn(task, round, which, drawing, &matches);
    for (const PreciseMatch& match : matches) {
      decoys->sought += Has(match.why_not, Reason::kPatchTooSmall) ? 0 : 1;
      decoys->found += match.found ? 1 : 0;
    }
  };
  DecoyMatches of_mirrored, of_exchanged;
  add(mirrored, &of_mirrored);
  for (std::size_t image = 0; image < images; ++image)
    add([&](std::size_t i) { return exchanged(i, image); }, &of_exchanged);
  const bool mirrored_more =
      of_mirrored.found * of_exchanged.sought > of_exchanged.found * of_mirrored.sought;
  return mirrored_more || of_exchanged.sought == 0 ? of_mirrored : of_exchanged;
}

}  // namespace orient::exterior
