#include "patchdb/rectify.h"

#include <Eigen/LU>

#include "core/imaging/resample.h"

namespace orient {
namespace {

constexpr int kMargin = 4;           // source pixels around a chip's area, for interpolation
constexpr double kMaxStretch = 4;    // of the source's window against the chip, a side
constexpr double kNodesPerCell = 2;  // bilinear between these is within the DEM's own bilinear

Eigen::Vector3d GroundAt(const HeightGrid& heights, const Eigen::Vector3d& centre, double east,
                         double north) {
  return {centre.x() + east, centre.y() + north, heights.At(east, north)};
}

// Source pixels of every chip pixel's centre; empty where one is not seen.
std::optional<std::vector<Eigen::Vector2d>> ProjectChip(const SourceView& source,
                                                        const HeightGrid& heights,
                                                        const Eigen::Vector3d& ground_m,
                                                        int chip_px, double gsd_m) {
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(static_cast<std::size_t>(chip_px) * static_cast<std::size_t>(chip_px));
  for (int row = 0; row < chip_px; ++row)
    for (int col = 0; col < chip_px; ++col) {
      const double east = (col + 0.5 - 0.5 * chip_px) * gsd_m;
      const double north = -(row + 0.5 - 0.5 * chip_px) * gsd_m;
      const auto pixel = source.PixelFromGround(GroundAt(heights, ground_m, east, north));
      if (!pixel || !pixel->allFinite()) return std::nullopt;
      pixels.push_back(*pixel);
    }
  return pixels;
}

std::optional<PixelWindow> WindowAround(const std::vector<Eigen::Vector2d>& pixels, int chip_px,
                                        const Raster& raster) {
  Eigen::Vector2d low = pixels.front(), high = pixels.front();
  for (const Eigen::Vector2d& pixel : pixels) {
    low = low.cwiseMin(pixel);
    high = high.cwiseMax(pixel);
  }
  if ((high - low).maxCoeff() > kMaxStretch * chip_px) return std::nullopt;
  if (high.x() < 0 || high.y() < 0 || low.x() > raster.Width() || low.y() > raster.Height())
    return std::nullopt;
  const Eigen::Vector2i first = low.array().floor().cast<int>() - kMargin;
  const Eigen::Vector2i last = high.array().ceil().cast<int>() + kMargin;
  return PixelWindow{first.x(), first.y(), last.x() - first.x(), last.y() - first.y()};
}

}  // namespace

HeightGrid CutHeights(const GroundSurface& surface, const Eigen::Vector2d& centre_m,
                      double half_width_m, double min_step_m) {
  const double step = std::max(min_step_m, surface.CellSize() / kNodesPerCell);
  const int half = std::max(1, static_cast<int>(std::ceil(half_width_m / step)));
  HeightGrid heights{2 * half + 1, step, {}};
  heights.heights_m.reserve(static_cast<std::size_t>(heights.size * heights.size));
  for (int i = -half; i <= half; ++i)
    for (int j = -half; j <= half; ++j) {
      const auto height = surface.HeightAt(centre_m.x() + j * step, centre_m.y() - i * step);
      heights.heights_m.push_back(height ? static_cast<float>(*height) : kNoData);
    }
  return heights;
}

double HeightSpread(const HeightGrid& heights) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float height : heights.heights_m) {
    if (std::isnan(height)) return std::numeric_limits<double>::quiet_NaN();
    low = std::min(low, height);
    high = std::max(high, height);
  }
  return static_cast<double>(high - low);
}

std::optional<Image> RectifyChip(const Raster& raster, const SourceView& source,
                                 const HeightGrid& heights, const Eigen::Vector3d& ground_m,
                                 int chip_px, double gsd_m) {
  const auto pixels = ProjectChip(source, heights, ground_m, chip_px, gsd_m);
  if (!pixels) return std::nullopt;
  const auto window = WindowAround(*pixels, chip_px, raster);
  if (!window) return std::nullopt;
  const ImageWindow part = raster.ReadGrey(*window);
  Image chip(chip_px, chip_px);
  for (std::size_t i = 0; i < chip.values.size(); ++i)
    chip.values[i] = SampleBicubic(part.image, part.ImageFromRaster((*pixels)[i]));
  return chip;
}

std::optional<Eigen::Matrix3d> GroundCovariance(const SourceView& source, const HeightGrid& heights,
                                                const Eigen::Vector3d& ground_m,
                                                double pointing_sigma_px, double height_sigma_m) {
  const double step = heights.step_m;
  const auto by_ground = PixelDerivatives(source, ground_m, std::min(step, 1.0));
  if (!by_ground) return std::nullopt;
  // The pixel moves with (X, Y, Z); Z - h(X, Y) is the height's error.
  Eigen::Matrix3d observed;
  observed.topRows<2>() = *by_ground;
  observed.row(2) << -(heights.At(step, 0) - heights.At(-step, 0)) / (2 * step),
      -(heights.At(0, step) - heights.At(0, -step)) / (2 * step), 1;
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  covariance.topLeftCorner<2, 2>() =
      source.OrientationCovariance(ground_m) +
      Eigen::Matrix2d::Identity() * (pointing_sigma_px * pointing_sigma_px);
  covariance(2, 2) = height_sigma_m * height_sigma_m;
  Eigen::Matrix3d inverse;
  bool invertible = false;
  observed.computeInverseWithCheck(inverse, invertible);
  if (!invertible) return std::nullopt;
  const Eigen::Matrix3d ground = inverse * covariance * inverse.transpose();
  if (!ground.allFinite()) return std::nullopt;
  return Eigen::Matrix3d(0.5 * (ground + ground.transpose()));
}

}  // namespace orient
