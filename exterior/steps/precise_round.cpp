#include "exterior/steps/precise_round.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "core/base/chi_square.h"
#include "core/base/median.h"
#include "core/base/side_by_side.h"
#include "core/raster/resample.h"
#include "exterior/steps/align.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/patch_observation.h"

namespace orient::exterior {
namespace {

constexpr int kPrecisePatches = 900;
// Of windows around a settled pose, beyond its sigmas; pixels of the reduction.
constexpr double kCloseMargin_px = 1.5;
constexpr std::size_t kDecoys = 200;  // of either kind, at most
// With so many matches by grey values, gradients are not worth their cost and lesser precision.
constexpr int kManyMatches = 100;

// Beyond it, further patches do not make the same pose more precise but give a different one.
const double kMovedChi2Limit = ChiSquareLimit(6, 1e-3);
const double kPriorChi2Limit = ChiSquareLimit(6, 1e-4);

Eigen::Vector2d WindowRadius(const PatchPrediction& prediction, double margin_px) {
  return prediction.Radius(kWindowSigmas) + Eigen::Vector2d::Constant(margin_px);
}

// A patch as it looks under the view; empty if it is too small there.
std::optional<AlignedPatch> Drawn(const PhotoTask& task, const PhotoView& view,
                                  const PatchPrediction& prediction, int reduction) {
  return AlignPatch(view, task.patches[prediction.patch], reduction, kMinSide_px, kMaxSide_px);
}

using Drawing = std::function<std::optional<AlignedPatch>(std::size_t)>;

// Searches by gradients for what grey values did not find; if they fail, too, adds the reasons.
void OrByGradients(const PreciseSearch& search, PreciseMatch* match) {
  PreciseMatch by_gradients = search.ByGradients();
  if (by_gradients.found) {
    *match = std::move(by_gradients);
    return;
  }
  for (const Finding& why : by_gradients.why_not)
    if (!Has(match->why_not, why.reason)) match->why_not.push_back(why);
}

// Larger windows are not kept for all of a photo's patches but read and correlated again.
constexpr double kMostKept_px = 40;  // of the reduction

// Matches what is drawn, around the predictions. If grey values find few (another season, film or
// decade), gradients are worth their cost and lesser precision. Returns whether they were used.
bool MatchDrawn(const PhotoTask& task, const PreciseRound& round,
                const std::vector<std::size_t>& which, const Drawing& drawing,
                std::vector<PreciseMatch>* matches) {
  const auto radius = [&](std::size_t i) {
    return WindowRadius(round.predictions[which[i]], round.margin_px);
  };
  const auto search = [&](std::size_t i) -> std::optional<PreciseSearch> {
    auto drawn = drawing(which[i]);
    if (!drawn) return std::nullopt;
    return PreciseSearch(*std::move(drawn), task.image, radius(i));
  };
  matches->resize(which.size());
  std::vector<std::optional<PreciseSearch>> kept(which.size());
  SideBySide(which.size(), [&](std::size_t i) {
    PreciseMatch& match = (*matches)[i];
    auto by_grey = search(i);
    if (!by_grey) {
      match.why_not = {{.reason = Reason::kPatchTooSmall}};
      return;
    }
    match = by_grey->ByGrey({});
    if (!match.found && radius(i).maxCoeff() <= kMostKept_px * round.reduction)
      kept[i] = std::move(by_grey);
  });
  const auto missing = std::count_if(matches->begin(), matches->end(),
                                     [](const PreciseMatch& match) { return !match.found; });
  if (!round.by_gradients && 2 * missing <= std::ssize(*matches)) return false;
  SideBySide(which.size(), [&](std::size_t i) {
    PreciseMatch& match = (*matches)[i];
    if (match.found) return;
    const auto missed = kept[i] ? std::move(kept[i]) : search(i);
    if (missed) OrByGradients(*missed, &match);
  });
  return true;
}

}  // namespace

int PreciseReduction(const PhotoTask& task, const PoseTrack& track) {
  constexpr std::size_t kAsked = 200;     // patches tell
  constexpr double kNearly = 0.9;         // of a whole number: the pose is not precise yet
  constexpr double kMostReduction = 4.0;  // errors of the photo itself are stated in its own pixels
  const PhotoView view = task.View(track.position, track.pose);
  const auto visible = Predict(view, track.covariance, task.patches, task.Prediction());
  std::vector<double> sides_px;
  for (std::size_t i = 0; i < visible.size(); i += 1 + visible.size() / kAsked)
    if (const auto side_px = PatchPixel(view, task.patches[visible[i].patch]))
      sides_px.push_back(*side_px);
  if (sides_px.empty()) return 1;
  // The finer ones decide, as they would become too small.
  const double finer_px = LowerQuartile(std::move(sides_px));
  return static_cast<int>(std::clamp(finer_px / kNearly, 1.0, kMostReduction));
}

PreciseRound MatchAll(const PhotoTask& task, const PhotoView& view, const Matrix6d& covariance,
                      double margin_px, int reduction) {
  PreciseRound round;
  round.view = view;
  round.reduction = reduction;
  round.margin_px = margin_px * reduction;
  const auto visible =
      Predict(view, covariance, task.patches, task.Prediction(), &round.not_visible);
  round.predictions = SelectSpread(visible, task.patches, kPrecisePatches, task.Prediction());
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < round.predictions.size(); ++i) {
    const PatchPrediction& prediction = round.predictions[i];
    const auto area =
        AreaToSearch(prediction.pixel, WindowRadius(prediction, round.margin_px), task.image);
    round.windows_px2.push_back(std::max(area.Size().prod(), 1.0));
    all.push_back(i);
  }
  round.window_px = LargestRadius(round.predictions, kWindowSigmas) + round.margin_px;
  round.by_gradients = MatchDrawn(
      task, round, all,
      [&](std::size_t i) { return Drawn(task, view, round.predictions[i], reduction); },
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
  CommonErrors common =
      CommonErrorsOf(track.position, round->view, observations.front().ground_m.z());
  common.reduction = round->reduction;
  round->estimate = EstimatePose(round->view, task.photo.prior, observations, common);
  if (round->estimate && round->estimate->prior_chi2 <= kPriorChi2Limit) return;
  // With a prior that is far off there may be no solution at all.
  round->estimate = EstimatePose(round->view, Weakened(task.photo.prior), observations, common);
  if (!round->estimate) return;
  const PosePrior& prior = task.photo.prior;
  const Vector6d off = PoseDifference(round->estimate->pose, prior.pose);
  round->estimate->prior_chi2 = off.dot(prior.covariance.ldlt().solve(off));
  round->contradicts_prior = round->estimate->prior_chi2 > kPriorChi2Limit;
}

namespace {

// The search for a patch close to where a settled pose projects it.
struct CloseSearch {
  PatchPrediction prediction;
  PreciseSearch search;
};

// One per prediction of the pose's round, set only for patches that it rejects or did not find.
struct CloseSearches {
  PhotoView view;
  double margin_px = 0, window_px = 0;
  std::vector<std::optional<CloseSearch>> of;
};

CloseSearches SearchClose(const PhotoTask& task, const PoseTrack& track,
                          const PreciseRound& settled) {
  std::vector<bool> stands(settled.matches.size(), false);
  for (std::size_t k = 0; k < settled.observed.size(); ++k)
    stands[settled.observed[k]] = !settled.estimate->rejected[k];
  CloseSearches close{
      task.View(track.position, track.pose), kCloseMargin_px * settled.reduction, 0, {}};
  close.of.resize(stands.size());
  std::map<std::size_t, PatchPrediction> visible;  // by patch
  for (const PatchPrediction& prediction :
       Predict(close.view, track.covariance, task.patches, task.Prediction()))
    visible[prediction.patch] = prediction;
  std::vector<std::pair<std::size_t, PatchPrediction>> open;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const auto now = visible.find(settled.predictions[i].patch);
    if (!stands[i] && now != visible.end()) open.emplace_back(i, now->second);
  }
  for (const auto& [i, prediction] : open)
    close.window_px =
        std::max(close.window_px, WindowRadius(prediction, close.margin_px).maxCoeff());
  SideBySide(open.size(), [&](std::size_t k) {
    const auto& [i, prediction] = open[k];
    if (auto drawn = Drawn(task, close.view, prediction, settled.reduction))
      close.of[i] = {prediction, PreciseSearch(*std::move(drawn), task.image,
                                               WindowRadius(prediction, close.margin_px))};
  });
  return close;
}

// The cue by which patches are searched for close to a settled pose.
enum class CloseCue { kGrey, kGradients, kEdges };

// The round with what is found close to its pose; unchanged if its pose does not hold. Gradients
// and edges are used only for patches found nowhere, as contradicting ones lie elsewhere.
PreciseRound WithClose(const PhotoTask& task, const PoseTrack& track, const PreciseRound& before,
                       const CloseSearches& close, CloseCue cue) {
  PreciseRound round = before;
  round.view = close.view;
  round.margin_px = close.margin_px;
  round.window_px = close.window_px;
  // So close, a second place nearly as good indicates an imprecise match, not an ambiguous one.
  // Gradients keep their ratio test: more places resemble them.
  const PreciseOptions options{.min_score_gap = 0, .edges = cue == CloseCue::kEdges};
  SideBySide(close.of.size(), [&](std::size_t i) {
    PreciseMatch& match = round.matches[i];
    if (!close.of[i] || (cue != CloseCue::kGrey && match.found)) return;
    round.predictions[i] = close.of[i]->prediction;
    if (cue == CloseCue::kGradients) return OrByGradients(close.of[i]->search, &match);
    PreciseMatch now = close.of[i]->search.ByGrey(options);
    if (now.found) match = std::move(now);
  });
  Resect(task, track, &round);
  if (!round.estimate) return before;
  const Vector6d moved = PoseDifference(round.estimate->pose, before.estimate->pose);
  const bool stays =
      moved.dot(before.estimate->honest_covariance.ldlt().solve(moved)) <= kMovedChi2Limit;
  return stays ? round : before;
}

double WorstSigma(const PhotoTask& task, const PreciseRound& round) {
  const double height_m = task.patches[round.predictions.front().patch].ground_m.z();
  return WorstProjectionSigma(round.view, round.estimate->honest_covariance, height_m);
}

}  // namespace

PreciseRound Complete(const PhotoTask& task, const PoseTrack& track, const PreciseRound& settled) {
  const CloseSearches close = SearchClose(task, track, settled);
  const auto with = [&](const PreciseRound& round, CloseCue cue) {
    return WithClose(task, track, round, close, cue);
  };
  PreciseRound points = with(settled, CloseCue::kGrey);
  if (points.estimate->used < kManyMatches) points = with(points, CloseCue::kGradients);
  const PreciseRound edges = with(points, CloseCue::kEdges);
  // Edges may err more than the points they add to, e.g. with a DEM too coarse for its terrain.
  return WorstSigma(task, edges) < WorstSigma(task, points) ? edges : points;
}

Square SquareOf(const PatchPrediction& prediction, int reduction) {
  const Eigen::Vector2d place = (prediction.pixel / (kMaxSide_px * reduction)).array().floor();
  return {std::lround(place.x()), std::lround(place.y())};
}

DecoyMatches MatchDecoys(const PhotoTask& task, const PreciseRound& round) {
  const std::vector<PatchPrediction>& predictions = round.predictions;
  std::set<Square> squares;
  std::vector<std::size_t> apart;
  for (std::size_t i = 0; i < predictions.size(); ++i)
    if (squares.insert(SquareOf(predictions[i], round.reduction)).second) apart.push_back(i);
  std::vector<std::size_t> which;
  const std::size_t count = std::min(apart.size(), kDecoys);
  for (std::size_t k = 0; k < count; ++k) which.push_back(apart[k * apart.size() / count]);

  const auto mirrored = [&](std::size_t i) -> std::optional<AlignedPatch> {
    auto drawn = Drawn(task, round.view, predictions[i], round.reduction);
    if (drawn) drawn->image = Mirrored(std::move(drawn->image));
    return drawn;
  };
  // If there are few windows, several images are searched for in each.
  const std::size_t images =
      std::clamp<std::size_t>(kDecoys / std::max<std::size_t>(count, 1), 1, 4);
  const auto exchanged = [&](std::size_t i, std::size_t image) -> std::optional<AlignedPatch> {
    const std::size_t all = predictions.size(), from = i + (image + 1) * all / (images + 1);
    const Eigen::Array2d clear =
        WindowRadius(predictions[i], round.margin_px).array() + kMaxSide_px * round.reduction;
    for (std::size_t k = 0; k < all; ++k) {
      const PatchPrediction& other = predictions[(from + k) % all];
      if (((other.pixel - predictions[i].pixel).array().abs() <= clear).all()) continue;
      auto drawn = Drawn(task, round.view, other, round.reduction);
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
