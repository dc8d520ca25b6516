#include "patchdb/harvest/further_views.h"

#include "core/matching/correlation.h"
#include "core/matching/least_squares_matching.h"
#include "core/raster/resample.h"
#include "patchdb/harvest/rectify.h"

namespace orient::patchdb {
namespace {

constexpr int kCore_px = 21;               // odd; this core alone must match at the same place
constexpr double kMaxDisagreement_px = 1;  // between correlation and least squares
constexpr double kMaxSigma_px = 0.3;
constexpr int kCoverageCells = 256;  // along the longer side
constexpr double kPeakDistance = 2.5;
constexpr int kWindowMargin = 5;  // chip pixels around the searched area, for interpolation

struct ChipMatch {
  Eigen::Vector2d shift;       // of the ground point, chip pixels
  Eigen::Matrix2d covariance;  // chip pixels^2
};

std::optional<ChipMatch> MatchChips(const Image& templ, const Image& window,
                                    const MatchOptions& options) {
  const auto peaks = FindPeaks(Correlate(templ, window), 2, kPeakDistance, options.min_score / 2);
  if (peaks.empty() || peaks[0].score < options.min_score) return std::nullopt;
  if (peaks.size() > 1 && peaks[0].score - peaks[1].score < options.min_score_gap)
    return std::nullopt;
  const Eigen::Vector2d centre = Eigen::Vector2d::Constant(0.5 * templ.width);
  LsmOptions lsm;
  lsm.geometry = LsmGeometry::kShift;
  lsm.max_shift_px = 2;
  const auto fit = MatchLeastSquares(templ, window, centre,
                                     {Eigen::Matrix2d::Identity(), peaks[0].position}, lsm);
  if (!fit || fit->gain <= 0 || fit->correlation < options.min_score) return std::nullopt;
  if ((fit->position - peaks[0].position - centre).norm() > kMaxDisagreement_px)
    return std::nullopt;
  if (std::sqrt(fit->covariance.trace() / 2) > kMaxSigma_px) return std::nullopt;
  return ChipMatch{fit->position - Eigen::Vector2d::Constant(0.5 * window.width), fit->covariance};
}

// Whether the template's middle alone matches best where the whole template does.
bool CoreAgrees(const Image& templ, const Image& window, const ChipMatch& match,
                const MatchOptions& options) {
  const int side = std::min(kCore_px, templ.width);
  const auto peaks = FindPeaks(Correlate(MiddleOf(templ, side, side), window), 1, kPeakDistance,
                               options.min_score);
  if (peaks.empty()) return false;
  const Eigen::Vector2d corner_of_no_shift = Eigen::Vector2d::Constant(0.5 * (window.width - side));
  return (peaks[0].position - corner_of_no_shift - match.shift).norm() <= kMaxDisagreement_px;
}

}  // namespace

Coverage::Coverage(const Raster& raster)
    : overview_(raster.ReadGrey(
          {0, 0, raster.Width(), raster.Height()},
          std::max(1.0, double(std::max(raster.Width(), raster.Height())) / kCoverageCells))) {}

bool Coverage::Covers(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2i cell =
      overview_.ImageFromRaster(pixel).array().floor().matrix().cast<int>();
  for (int row = cell.y() - 1; row <= cell.y() + 1; ++row)
    for (int col = cell.x() - 1; col <= cell.x() + 1; ++col)
      if (col < 0 || row < 0 || col >= overview_.image.width || row >= overview_.image.height ||
          std::isnan(overview_.image.At(col, row)))
        return false;
  return true;
}

std::optional<double> ViewingPenalty(const FurtherSource& source, const Eigen::Vector3d& ground_m,
                                     int chip_px) {
  const auto pixel = source.view->PixelFromGround(ground_m);
  if (!pixel || (source.coverage != nullptr && !source.coverage->Covers(*pixel)))
    return std::nullopt;
  const double reach = 0.75 * chip_px;  // corners of a rotated square
  if (!(pixel->minCoeff() > reach) || !(pixel->x() < source.raster->Width() - reach) ||
      !(pixel->y() < source.raster->Height() - reach))
    return std::nullopt;
  const auto gsd = GsdAt(*source.view, ground_m);
  if (!gsd) return std::nullopt;
  return *gsd * (1 + source.view->HeightEffect(ground_m).head<2>().norm());
}

std::optional<Sighting> FindIn(const FurtherSource& source, const Patch& patch,
                               const MatchOptions& options) {
  const int side = std::min(options.template_px, patch.chip.width);
  int window_px = side + 2 * (static_cast<int>(std::ceil(options.radius_px)) + kWindowMargin);
  if (window_px % 2 == 0) ++window_px;
  const auto window = RectifyChip(*source.raster, *source.view, patch.heights, patch.ground_m,
                                  window_px, patch.gsd_m);
  if (!window) return std::nullopt;
  const Image templ = MiddleOf(patch.chip, side, side);
  const auto match = MatchChips(templ, *window, options);
  if (!match || !CoreAgrees(templ, *window, *match, options)) return std::nullopt;
  const double gsd = patch.gsd_m;
  const double east = match->shift.x() * gsd, north = -match->shift.y() * gsd;
  Eigen::Vector3d shown = patch.ground_m + Eigen::Vector3d(east, north, 0);
  shown.z() = patch.heights.At(east, north);
  const auto pixel = source.view->PixelFromGround(shown);
  const auto by_ground = PixelDerivatives(*source.view, shown, 1.0);
  if (!pixel || !by_ground) return std::nullopt;
  Eigen::Matrix2d by_chip = by_ground->leftCols<2>() * gsd;
  by_chip.col(1) *= -1;  // rows count southwards
  Sighting sighting{source.view, *pixel, by_chip * match->covariance * by_chip.transpose()};
  sighting.covariance_px2 +=
      Eigen::Matrix2d::Identity() * (kMatchModelSigma_px * kMatchModelSigma_px);
  return sighting;
}

}  // namespace orient::patchdb
