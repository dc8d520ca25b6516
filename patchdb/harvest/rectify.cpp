#include "patchdb/harvest/rectify.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/raster/resample.h"
#include "patchdb/harvest/undeclared_void.h"

namespace orient::patchdb {
namespace {

constexpr int kMargin = 4;          // source pixels around a chip's area, for interpolation
constexpr double kMaxStretch = 4;   // largest ratio of the source window's side to the chip's
constexpr int kMaxLatticeStep = 4;  // chip pixels
// As many as the DEM's own: between nodes a chip's heights depart from the DEM's by as much as the
// DEM's do from the ground, and in the middle, where its point lies, not at all.
constexpr double kNodesPerCell = 2;

Eigen::Vector3d GroundAt(const HeightGrid& heights, const Eigen::Vector3d& centre, double east,
                         double north) {
  return {centre.x() + east, centre.y() + north, heights.At(east, north)};
}

// Source pixels for the places of a chip, exact on a lattice and linear between its nodes: a DEM's
// nodes are several chip pixels apart, so the lens need not be evaluated for every chip pixel.
class ChipLattice {
 public:
  // Empty where part of the chip is not seen.
  static std::optional<ChipLattice> Make(const SourceView& source, const HeightGrid& heights,
                                         const Eigen::Vector3d& ground_m, int chip_px,
                                         double gsd_m) {
    const int step = std::clamp(static_cast<int>(heights.step_m / gsd_m), 1, kMaxLatticeStep);
    ChipLattice lattice(step, (chip_px + step - 1) / step + 1);
    for (int row = 0; row < lattice.nodes_; ++row)
      for (int col = 0; col < lattice.nodes_; ++col) {
        // The last nodes may lie beyond the chip, where heights and source may end.
        const double across = std::min(col * step, chip_px), down = std::min(row * step, chip_px);
        const double east = (across - 0.5 * chip_px) * gsd_m;
        const double north = -(down - 0.5 * chip_px) * gsd_m;
        const auto pixel = source.PixelFromGround(GroundAt(heights, ground_m, east, north));
        if (!pixel || !pixel->allFinite()) return std::nullopt;
        lattice.pixels_.push_back(*pixel);
      }
    lattice.last_ = chip_px - (lattice.nodes_ - 2) * step;
    return lattice;
  }

  const std::vector<Eigen::Vector2d>& Nodes() const { return pixels_; }

  // At the centre of a chip pixel.
  Eigen::Vector2d At(int col, int row) const {
    const int i = col / step_, j = row / step_;
    const double u = (col - i * step_ + 0.5) / Width(i), v = (row - j * step_ + 0.5) / Width(j);
    return (1 - v) * ((1 - u) * Node(i, j) + u * Node(i + 1, j)) +
           v * ((1 - u) * Node(i, j + 1) + u * Node(i + 1, j + 1));
  }

 private:
  ChipLattice(int step, int nodes) : step_(step), nodes_(nodes) {}
  double Width(int cell) const { return cell == nodes_ - 2 ? last_ : step_; }
  const Eigen::Vector2d& Node(int col, int row) const {
    return pixels_[static_cast<std::size_t>(row * nodes_ + col)];
  }

  int step_, nodes_;
  double last_ = 1;  // chip pixels, of the last cell
  std::vector<Eigen::Vector2d> pixels_;
};

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

struct ChipArea {
  ChipLattice lattice;
  PixelWindow window;  // of the source
};

std::optional<ChipArea> AreaOf(const Raster& raster, const SourceView& source,
                               const HeightGrid& heights, const Eigen::Vector3d& ground_m,
                               int chip_px, double gsd_m) {
  auto lattice = ChipLattice::Make(source, heights, ground_m, chip_px, gsd_m);
  if (!lattice) return std::nullopt;
  const auto window = WindowAround(lattice->Nodes(), chip_px, raster);
  if (!window) return std::nullopt;
  return ChipArea{std::move(*lattice), *window};
}

Image Resample(const ImageWindow& part, const ChipLattice& lattice, int chip_px) {
  Image chip(chip_px, chip_px);
  for (int row = 0; row < chip_px; ++row)
    for (int col = 0; col < chip_px; ++col)
      chip.At(col, row) = SampleBicubic(part.image, part.ImageFromRaster(lattice.At(col, row)));
  return chip;
}

// Height above the chip's ground, chip pixels, at which the line of sight to a pixel (relative to
// the middle) meets the other surface; 0 if unobstructed or, for orthophotos, unknown.
double MetOnTheWay(const GroundSurface& surface, const SourceView& source, const Patch& patch,
                   double col, double row) {
  constexpr double kHighest = 150;  // m; nothing above that is considered
  if (source.IsOrthophoto()) return 0;
  Eigen::Vector3d ground = patch.ground_m + patch.gsd_m * Eigen::Vector3d(col, -row, 0);
  ground.z() = patch.heights.At(ground.x() - patch.ground_m.x(), ground.y() - patch.ground_m.y());
  const Eigen::Vector3d sight = source.HeightEffect(ground);
  const double top = std::min(kHighest, surface.MaxHeight() - ground.z());
  // Steps of one chip pixel over the ground.
  const double step = patch.gsd_m / std::max(sight.head<2>().norm(), 0.05);
  double met = 0;
  for (double above = step; above < top; above += step) {
    const Eigen::Vector3d place = ground + above * sight;
    const auto height = surface.HeightAt(place.x(), place.y());
    if (height && *height > place.z()) met = above;
  }
  return met / patch.gsd_m;
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
  const auto area = AreaOf(raster, source, heights, ground_m, chip_px, gsd_m);
  if (!area) return std::nullopt;
  return Resample(raster.ReadGrey(area->window), area->lattice, chip_px);
}

void RequireNoSign(const Image& chip, const Raster& raster, const SourceView& source,
                   const HeightGrid& heights, const Eigen::Vector3d& ground_m, double gsd_m) {
  const auto negative = [](float value) { return value < 0; };
  if (std::none_of(chip.values.begin(), chip.values.end(), negative)) return;
  // Interpolation overshoots; the source's own values tell.
  const auto area = AreaOf(raster, source, heights, ground_m, chip.width, gsd_m);
  if (!area) return;
  const Image grey = raster.ReadGrey(area->window).image;
  const auto first = std::find_if(grey.values.begin(), grey.values.end(), negative);
  if (first != grey.values.end())
    throw InputError(fmt::format(
        "{}: has grey values below 0 ({}); declare them with gdal_edit.py -a_nodata if they mark "
        "missing data, otherwise convert it with gdal_translate -ot UInt16 -scale MIN MAX 0 65535",
        raster.Path(), *first));
}

double VoidShare(const Raster& raster, const SourceView& source, const HeightGrid& heights,
                 const Eigen::Vector3d& ground_m, int chip_px, double gsd_m) {
  const auto area = AreaOf(raster, source, heights, ground_m, chip_px, gsd_m);
  if (!area) return 0;
  constexpr int kReach = kVoidReach_px;
  const PixelWindow& inner = area->window;
  const ImageWindow part = raster.ReadGrey({inner.col - kReach, inner.row - kReach,
                                            inner.width + 2 * kReach, inner.height + 2 * kReach});
  const std::vector<std::uint8_t> voids = UndeclaredVoids(part.image, raster.BitsPerSample());
  int count = 0;
  for (int row = 0; row < chip_px; ++row)
    for (int col = 0; col < chip_px; ++col) {
      const Eigen::Vector2i at =
          part.ImageFromRaster(area->lattice.At(col, row)).array().floor().cast<int>();
      const bool inside =
          at.minCoeff() >= 0 && at.x() < part.image.width && at.y() < part.image.height;
      const auto pixel =
          static_cast<std::size_t>(at.y()) * static_cast<std::size_t>(part.image.width) +
          static_cast<std::size_t>(at.x());
      count += inside && voids[pixel] != 0 ? 1 : 0;
    }
  return static_cast<double>(count) / (static_cast<double>(chip_px) * chip_px);
}

std::vector<Image> RectifyColour(const ColourRaster& colour, const Raster& raster,
                                 const SourceView& source, const HeightGrid& heights,
                                 const Eigen::Vector3d& ground_m, int chip_px, double gsd_m) {
  const auto area = AreaOf(raster, source, heights, ground_m, chip_px, gsd_m);
  if (!area) return {};
  std::vector<Image> bands;
  for (const ImageWindow& part : colour.Read(area->window))
    bands.push_back(Resample(part, area->lattice, chip_px));
  return bands;
}

std::optional<double> LeanOf(const GroundSurface& surface, const SourceView& source,
                             const Patch& patch) {
  constexpr double kStep = 2, kMiddle = 8;  // chip pixels
  constexpr double kShare = 0.75;
  const double half = 0.5 * patch.chip.width;
  double middle = -1;
  int places = 0;
  std::vector<double> departures;
  for (double row = -half + 0.5; row < half; row += kStep)
    for (double col = -half + 0.5; col < half; col += kStep, ++places) {
      const double east = col * patch.gsd_m, north = -row * patch.gsd_m;
      const auto height = surface.HeightAt(patch.ground_m.x() + east, patch.ground_m.y() + north);
      if (!height) continue;
      departures.push_back(std::abs(*height - patch.heights.At(east, north)) / patch.gsd_m);
      if (std::hypot(col, row) <= kMiddle) middle = std::max(middle, departures.back());
    }
  if (middle < 0 || static_cast<double>(departures.size()) < kShare * places) return std::nullopt;
  for (const double col : {-3.0, 0.0, 3.0})
    for (const double row : {-3.0, 0.0, 3.0})
      middle = std::max(middle, MetOnTheWay(surface, source, patch, col, row));
  const auto rank =
      static_cast<std::ptrdiff_t>(kShare * static_cast<double>(departures.size() - 1));
  std::nth_element(departures.begin(), departures.begin() + rank, departures.end());
  return std::max(middle, departures[static_cast<std::size_t>(rank)]);
}

}  // namespace orient::patchdb
