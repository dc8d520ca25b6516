#include "exterior/steps/match.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/principal_axes.h"
#include "core/matching/gradient_channels.h"
#include "core/matching/least_squares_matching.h"

namespace orient::exterior {
namespace {

constexpr double kMaxDisagreement_px = 1.0;  // between correlation and least squares
constexpr double kMaxSigma_px = 0.3;
constexpr double kMinGreyPeak = 0.3;  // below, peaks are due to chance

// With gradients: least ratio of the best place's score to the second-best's, and the ratio if grey
// values are best there, too. For patches of 61 px; the excess over 1 grows with fewer pixels as
// chance does. Measured on orthophotos of different years: with these, about
// 1 % of the patches are found at a wrong place.
constexpr double kMinGradientRatio = 1.4;
constexpr double kMinGradientRatioWithGrey = 1.1;
constexpr double kMaxGradientSigma_px = 0.5;
constexpr int kMaxCandidates = 5;
constexpr double kMinGradientScore = 0.2;

// Peaks closer than this are one peak.
constexpr double kPeakDistance = 2.5;

// The photo around the prediction.
ImageWindow WindowFor(const AlignedPatch& patch, const PhotoImage& photo,
                      const Eigen::Vector2d& radius_px) {
  const SearchArea area = AreaToSearch(patch.predicted_px, radius_px, photo);
  const Eigen::Vector2d half =
      area.Size() / 2 + patch.reduction * (patch.Centre() + Eigen::Vector2d::Constant(1.5));
  return photo.Around((area.first + area.last) / 2, half, static_cast<int>(patch.reduction));
}

// Positions of the template's corner in the window.
std::vector<Peak> PeaksOf(const Image& scores, int max_peaks, double min_score) {
  if (scores.Empty()) return {};
  return FindPeaks(scores, max_peaks, kPeakDistance, min_score);
}

Eigen::Vector2d ScanFromPeak(const AlignedPatch& patch, const ImageWindow& window,
                             const Peak& peak) {
  return window.RasterFromImage(peak.position + patch.Centre());
}

PreciseMatch NotFound(Reason reason) {
  PreciseMatch match;
  match.why_not = {{.reason = reason}};
  return match;
}

Image Crop(const Image& image, const Eigen::Vector2i& corner, int side) {
  Image crop(side, side, kNoData);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      const int c = corner.x() + col, r = corner.y() + row;
      if (c >= 0 && r >= 0 && c < image.width && r < image.height)
        crop.At(col, row) = image.At(c, r);
    }
  return crop;
}

// Side of the middle part that is searched for in the patch, as a share of the place found.
constexpr double kMiddleShare = 0.6;
constexpr double kMaxReturn_px = 1.5;

// Whether forward and backward matching by gradients agree: the middle of the place in the photo is
// found again in the middle of the patch. `corner`: the patch's corner in the window.
bool ComesBack(const AlignedPatch& patch, const ImageWindow& window,
               const Eigen::Vector2d& corner) {
  const int side = patch.image.width;
  const int inner = static_cast<int>(kMiddleShare * side) | 1;
  const int margin = (side - inner) / 2;
  const Eigen::Vector2i nearest = corner.array().round().cast<int>();
  const Image middle = Crop(window.image, nearest + Eigen::Vector2i::Constant(margin), inner);
  const std::vector<Peak> peaks =
      PeaksOf(CorrelateChannels(ChannelsOf(middle), ChannelsOf(patch.image)), 1, 0);
  const Eigen::Vector2d expected =
      Eigen::Vector2d::Constant(margin) + nearest.cast<double>() - corner;
  return !peaks.empty() && (peaks.front().position - expected).norm() <= kMaxReturn_px;
}

// If the correlation's peak and least squares differ along the weaker axis only, the match counts
// as that of an edge: determined along the stronger axis, open along the weaker one.
void LeaveWeakestOpen(LsmResult* fit) {
  if (fit->along) return;
  const Eigen::Vector2d along = AxesOf(fit->covariance).vectors.col(1);
  fit->covariance += std::pow(kOpenAlongEdge_px, 2) * along * along.transpose();
  fit->along = along;
}

// The part of an offset that the match determines: for an edge, across it only.
Eigen::Vector2d Across(const LsmResult& fit, const Eigen::Vector2d& offset) {
  return fit.along ? offset - *fit.along * fit.along->dot(offset) : offset;
}

PreciseMatch MatchGrey(const AlignedPatch& patch, const ImageWindow& window,
                       const std::vector<Peak>& peaks, const PreciseOptions& options) {
  if (peaks.empty()) return NotFound(Reason::kNoCorrelationPeak);
  const Peak& best = peaks.front();
  if (best.score < options.min_score) return NotFound(Reason::kLowCorrelation);
  if (peaks.size() > 1 && best.score - peaks[1].score < options.min_score_gap)
    return NotFound(Reason::kCorrelationAmbiguous);

  LsmOptions lsm;
  lsm.geometry = LsmGeometry::kShift;
  lsm.max_shift_px = 2;
  lsm.edges = options.edges;
  auto fit = MatchLeastSquares(patch.image, window.image, patch.Centre(),
                               Affine2d{Eigen::Matrix2d::Identity(), best.position}, lsm);
  if (!fit) return NotFound(Reason::kMatchingNotConverged);
  if (fit->gain <= 0 || fit->correlation < options.min_score)
    return NotFound(Reason::kMatchingOfAnotherTexture);
  const Eigen::Vector2d peak = best.position + patch.Centre();
  if (options.edges && (fit->position - peak).norm() > kMaxDisagreement_px) LeaveWeakestOpen(&*fit);
  if (Across(*fit, fit->position - peak).norm() > kMaxDisagreement_px)
    return NotFound(Reason::kMatchingDisagrees);
  const double variance =
      options.edges ? AxesOf(fit->covariance).values[0] : fit->covariance.trace() / 2;
  if (std::sqrt(variance) > kMaxSigma_px) return NotFound(Reason::kTextureTooWeak);
  const Eigen::Vector2d predicted = window.ImageFromRaster(patch.predicted_px);
  fit->position = predicted + Across(*fit, fit->position - predicted);
  PreciseMatch match;
  match.pixel = window.RasterFromImage(fit->position);
  match.covariance_px2 = fit->covariance * patch.reduction * patch.reduction;
  match.ncc = fit->correlation;
  match.found = true;
  return match;
}

// The ratio required of a patch of 61 px, converted to another side: with fewer pixels, chance
// brings the second-best place closer.
double RatioFor(int side_px, double of_61_px) {
  constexpr double kSide = 61;
  return 1 + (of_61_px - 1) * std::sqrt(std::max(1.0, kSide / side_px));
}

// `grey` may be empty.
PreciseMatch MatchGradients(const AlignedPatch& patch, const ImageWindow& window,
                            const std::vector<Peak>& grey) {
  const GradientChannels templ = ChannelsOf(patch.image), image = ChannelsOf(window.image);
  const std::vector<Peak> peaks = PeaksOf(CorrelateChannels(templ, image), 2, 0);
  if (peaks.empty()) return NotFound(Reason::kNoGradients);
  const Peak& best = peaks.front();
  const bool agree =
      !grey.empty() && (grey.front().position - best.position).norm() <= kPeakDistance;
  const double ratio =
      RatioFor(patch.image.width, agree ? kMinGradientRatioWithGrey : kMinGradientRatio);
  if (peaks.size() > 1 && best.score < ratio * peaks[1].score)
    return NotFound(Reason::kGradientsAmbiguous);

  const auto fit = MatchChannels(templ, image, best.position, 2);
  if (!fit) return NotFound(Reason::kGradientsNotConverged);
  if ((fit->corner - best.position).norm() > kMaxDisagreement_px)
    return NotFound(Reason::kGradientsDisagree);
  if (std::sqrt(fit->covariance.trace() / 2) > kMaxGradientSigma_px)
    return NotFound(Reason::kGradientsTooWeak);
  if (!ComesBack(patch, window, fit->corner)) return NotFound(Reason::kFoundElsewhereInPatch);

  PreciseMatch match;
  match.pixel = window.RasterFromImage(fit->corner + patch.Centre());
  match.covariance_px2 = fit->covariance * patch.reduction * patch.reduction;
  match.ncc = fit->correlation;
  match.cue = MatchCue::kGradients;
  match.found = true;
  return match;
}

// Whether grey values suffice: a place that is nearly the same, and far better than any other.
bool StandsOut(const std::vector<Peak>& peaks) {
  constexpr double kNearlyTheSame = 0.8;
  constexpr double kFarBetter = 0.15;
  return !peaks.empty() && peaks[0].score > kNearlyTheSame &&
         (peaks.size() < 2 || peaks[0].score - peaks[1].score > kFarBetter);
}

// Best of the one, best of the other, second of the one ...; a place in both counts once.
std::vector<Peak> Interleaved(const std::vector<Peak>& one, const std::vector<Peak>& other,
                              std::size_t count) {
  std::vector<Peak> merged;
  const auto add = [&](const std::vector<Peak>& peaks, std::size_t i) {
    if (i >= peaks.size() || merged.size() >= count) return;
    const bool known = std::any_of(merged.begin(), merged.end(), [&](const Peak& peak) {
      return (peak.position - peaks[i].position).norm() < kPeakDistance;
    });
    if (!known) merged.push_back(peaks[i]);
  };
  for (std::size_t i = 0; i < count; ++i) {
    add(one, i);
    add(other, i);
  }
  return merged;
}

}  // namespace

SearchArea AreaToSearch(const Eigen::Vector2d& predicted_px, const Eigen::Vector2d& radius_px,
                        const PhotoImage& photo) {
  const Eigen::Vector2d corner(photo.Width(), photo.Height());
  const Eigen::Vector2d none = Eigen::Vector2d::Zero();
  return {(predicted_px - radius_px).cwiseMax(none).cwiseMin(corner),
          (predicted_px + radius_px).cwiseMax(none).cwiseMin(corner)};
}

std::vector<Candidate> FindCandidates(const AlignedPatch& patch, const PhotoImage& photo,
                                      const Eigen::Vector2d& radius_px,
                                      const CandidateOptions& options) {
  const ImageWindow window = WindowFor(patch, photo, radius_px);
  std::vector<Peak> peaks =
      PeaksOf(Correlate(patch.image, window.image), kMaxCandidates, options.min_score);
  if (options.gradients && !StandsOut(peaks)) {
    const Image scores = CorrelateChannels(ChannelsOf(patch.image), ChannelsOf(window.image));
    peaks = Interleaved(PeaksOf(scores, kMaxCandidates, kMinGradientScore), peaks,
                        static_cast<std::size_t>(kMaxCandidates));
  }
  std::vector<Candidate> candidates;
  for (const Peak& peak : peaks)
    candidates.push_back({ScanFromPeak(patch, window, peak), peak.score});
  return candidates;
}

PreciseSearch::PreciseSearch(AlignedPatch patch, const PhotoImage& photo,
                             const Eigen::Vector2d& radius_px)
    : patch_(std::move(patch)),
      window_(WindowFor(patch_, photo, radius_px)),
      grey_(PeaksOf(Correlate(patch_.image, window_.image), 2, kMinGreyPeak)) {}

PreciseMatch PreciseSearch::ByGrey(const PreciseOptions& options) const {
  return MatchGrey(patch_, window_, grey_, options);
}

PreciseMatch PreciseSearch::ByGradients() const { return MatchGradients(patch_, window_, grey_); }

}  // namespace orient::exterior
