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
// With so many by grey values, what gradients add is not worth their cost and lesser precision.
constexpr int kManyMatches = 100;

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

// What grey values did not find, by gradients; why neither did.
void OrByGradients(const PreciseSearch& search, PreciseMatch* match) {
  PreciseMatch by_gradients = search.ByGradients();
  if (!by_gradients.found)
    match->why_not.insert(match->why_not.end(), by_gradients.why_not.begin(),
                          by_gradients.why_not.end());
  else
    *match = std::move(by_gradients);
}

// What is drawn, around the predictions. Another season, film or decade: where grey values find
// few, gradients are worth their cost and their lesser precision. Says whether they were asked.
bool MatchDrawn(const PhotoTask& task, const PreciseRound& round,
                const std::vector<std::size_t>& which, const Drawing& drawing,
                std::vector<PreciseMatch>* matches) {
  matches->resize(which.size());
  std::vector<std::optional<PreciseSearch>> missed(which.size());
  SideBySide(which.size(), [&](std::size_t i) {
    PreciseMatch& match = (*matches)[i];
    auto drawn = drawing(which[i]);
    if (!drawn) {
      match.why_not = {{.reason = Reason::kPatchTooSmall}};
      return;
    }
    const PatchPrediction& prediction = round.predictions[which[i]];
    PreciseSearch search(*std::move(drawn), task.image, WindowRadius(prediction, round.margin_px));
    match = search.ByGrey({});
    if (!match.found) missed[i] = std::move(search);
  });
  const auto missing = std::count_if(matches->begin(), matches->end(),
                                     [](const PreciseMatch& match) { return !match.found; });
  if (!round.by_gradients && 2 * missing <= std::ssize(*matches)) return false;
  SideBySide(missed.size(), [&](std::size_t i) {
    if (missed[i]) OrByGradients(*missed[i], &(*matches)[i]);
  });
  return true;
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

// What a settled pose rejects or did not find, close to where it sees it. One per prediction.
using CloseSearches = std::vector<std::optional<PreciseSearch>>;

// `close`: the settled round; its predictions become those of the searches.
CloseSearches SearchClose(const PhotoTask& task, const PoseTrack& track, PreciseRound* close) {
  std::vector<bool> stands(close->matches.size(), false);
  for (std::size_t k = 0; k < close->observed.size(); ++k)
    stands[close->observed[k]] = !close->estimate->rejected[k];
  close->view = task.View(track.position, track.pose);
  close->margin_px = kCloseMargin_px;
  close->window_px = 0;
  std::map<std::size_t, PatchPrediction> visible;  // by patch
  for (const PatchPrediction& prediction :
       Predict(close->view, track.covariance, task.patches, task.Prediction()))
    visible[prediction.patch] = prediction;
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < stands.size(); ++i) {
    const auto now = visible.find(close->predictions[i].patch);
    if (stands[i] || now == visible.end()) continue;
    close->predictions[i] = now->second;
    open.push_back(i);
    close->window_px =
        std::max(close->window_px, WindowRadius(now->second, kCloseMargin_px).maxCoeff());
  }
  CloseSearches searches(stands.size());
  SideBySide(open.size(), [&](std::size_t k) {
    const PatchPrediction& prediction = close->predictions[open[k]];
    if (auto drawn = Drawn(task, close->view, prediction))
      searches[open[k]].emplace(*std::move(drawn), task.image,
                                WindowRadius(prediction, kCloseMargin_px));
  });
  return searches;
}

// By what is searched for close to a settled pose.
enum class CloseCue { kGrey, kGradients, kEdges };

// With what is found so close to the pose of the settled round; that round where the pose does not
// stand. Gradients and edges: only of what was found nowhere, for what contradicts lies elsewhere.
PreciseRound WithClose(const PhotoTask& task, const PoseTrack& track, const PreciseRound& settled,
                       const CloseSearches& searches, CloseCue cue) {
  PreciseRound round = settled;
  // So close, a second place nearly as good says how well the patch is determined, not which it is.
  const PreciseOptions options{.min_score_gap = 0, .edges = cue == CloseCue::kEdges};
  SideBySide(searches.size(), [&](std::size_t i) {
    PreciseMatch& before = round.matches[i];
    if (!searches[i] || (cue != CloseCue::kGrey && before.found)) return;
    if (cue == CloseCue::kGradients) return OrByGradients(*searches[i], &before);
    PreciseMatch match = searches[i]->ByGrey(options);
    if (match.found || !before.found) before = std::move(match);
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
  PreciseRound close = settled;
  const CloseSearches searches = SearchClose(task, track, &close);
  const auto with = [&](const PreciseRound& round, CloseCue cue) {
    return WithClose(task, track, round, searches, cue);
  };
  PreciseRound points = with(close, CloseCue::kGrey);
  if (points.estimate->used < kManyMatches) points = with(points, CloseCue::kGradients);
  const PreciseRound edges = with(points, CloseCue::kEdges);
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
