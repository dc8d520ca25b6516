#include "ortho/rectifier.h"

#include <algorithm>
#include <cmath>

#include "core/raster/colour_bands.h"
#include "core/raster/resample.h"
#include "core/terrain/footprint.h"

namespace orient::ortho {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kAverage = 1.2;  // scan pixels per map pixel from which on areas are averaged

std::size_t SizeOf(const PixelWindow& window) {
  return static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
}

// The part of the scan needed for interpolation at the places seen; of zero width if there are
// none.
PixelWindow ScanWindow(const Rectifier::Places& places, double factor, const BandRaster& scan) {
  Bounds bounds = Bounds::OfNothing();
  for (std::size_t i = 0; i < places.shown.size(); ++i)
    if (places.shown[i] == Shown::kSeen)
      bounds.Include(places.scan_px[i].x(), places.scan_px[i].y());
  if (bounds.min_x > bounds.max_x) return {};
  const double margin = 3 * std::max(1.0, factor);
  const auto clipped = [](double value, int size) {
    return static_cast<int>(std::clamp(value, 0.0, static_cast<double>(size)));
  };
  PixelWindow window;
  window.col = clipped(std::floor(bounds.min_x - margin), scan.Width());
  window.row = clipped(std::floor(bounds.min_y - margin), scan.Height());
  window.width = clipped(std::ceil(bounds.max_x + margin), scan.Width()) - window.col;
  window.height = clipped(std::ceil(bounds.max_y + margin), scan.Height()) - window.row;
  return window;
}

// Scan pixels between two neighbouring pixels of the window, the mean over it.
double Reduction(const Rectifier::Places& places, const PixelWindow& window) {
  double sum = 0;
  int count = 0;
  constexpr int kStep = 16;
  for (int row = 0; row < window.height; row += kStep)
    for (int col = 0; col + 1 < window.width; col += kStep) {
      const std::size_t i = static_cast<std::size_t>(row) * window.width + col;
      if (places.shown[i] != Shown::kSeen || places.shown[i + 1] != Shown::kSeen) continue;
      sum += (places.scan_px[i + 1] - places.scan_px[i]).norm();
      ++count;
    }
  return count == 0 ? 1 : sum / count;
}

// Limits values to the format's range, since interpolation overshoots; inverts a negative.
float Clamped(const BandFormat& format, float value, bool negative) {
  if (!format.IsUnsigned()) return value;
  const float most = GreatestValue(format.bits);
  return std::clamp(negative ? most - value : value, 0.0f, most);
}

}  // namespace

Rectifier::Rectifier(const PhotoView& view, const GroundSurface& surface, const BandRaster& scan,
                     const RectifierOptions& options)
    : surface_(surface),
      scan_(scan),
      negative_(options.negative),
      most_values_(options.most_values),
      centre_m_(view.pose.position_m),
      photo_from_ground_(view.pose.GroundFromPhoto().transpose()),
      principal_distance_mm_(view.camera.principal_distance_mm),
      table_(view, options.border_mm, options.marks),
      hidden_(surface, view.pose.position_m) {}

Rectifier::Place Rectifier::PlaceOf(const Vector2d& ground_m) const {
  const auto height = surface_.HeightAt(ground_m.x(), ground_m.y());
  if (!height) return {};
  const Vector3d d =
      photo_from_ground_ * (Vector3d(ground_m.x(), ground_m.y(), *height) - centre_m_);
  if (!(d.z() < 0)) return {};
  const auto pixel = table_.PixelOf(d.head<2>() * (-principal_distance_mm_ / d.z()));
  if (!pixel) return {};
  return {*pixel, *height, true};
}

// Interpolates linearly between places at most half a cell of the surface apart if the one midway
// lies on their line: the surface has one bend between them (two near a node of a rotated grid),
// which moves a place by at most twice as much as the one midway.
std::vector<Rectifier::Place> Rectifier::PlacesOfRow(const MapGrid& grid, const PixelWindow& window,
                                                     int row) const {
  constexpr int kMostStep = 16, kLeastStep = 4;
  constexpr double kStraight_px = 0.01;
  const double half_cell_px = 0.5 * surface_.CellAlongX() / grid.gsd_m;
  const int half = static_cast<int>(std::min<double>(kMostStep, half_cell_px)) / 2;
  const int step = std::max(2 * half, 1);
  const auto place = [&](int col) {
    return PlaceOf(grid.GroundFromPixel(window.col + col + 0.5, window.row + row + 0.5));
  };
  std::vector<Place> places(static_cast<std::size_t>(window.width));
  int col = 0;
  if (step >= kLeastStep && window.width > 0) places[0] = place(0);
  for (; step >= kLeastStep && col + step < window.width; col += step) {
    Place* from = &places[static_cast<std::size_t>(col)];
    const Place middle = place(col + half), to = place(col + step);
    from[step] = to;
    const bool straight =
        from->seen && middle.seen && to.seen &&
        (middle.scan_px - 0.5 * (from->scan_px + to.scan_px)).norm() < kStraight_px;
    for (int i = 1; i < step; ++i) {
      const double t = static_cast<double>(i) / step;
      from[i] = straight ? Place{(1 - t) * from->scan_px + t * to.scan_px,
                                 (1 - t) * from->height + t * to.height, true}
                         : place(col + i);
    }
  }
  for (; col < window.width; ++col) places[static_cast<std::size_t>(col)] = place(col);
  return places;
}

Rectifier::Places Rectifier::PlacesOf(const MapGrid& grid, const PixelWindow& window) const {
  Places places{std::vector<Vector2d>(SizeOf(window)),
                std::vector<Shown>(SizeOf(window), Shown::kNothing)};
  std::vector<double> heights(SizeOf(window));
  std::size_t i = 0;
  for (int row = 0; row < window.height; ++row)
    for (const Place& place : PlacesOfRow(grid, window, row)) {
      places.scan_px[i] = place.scan_px;
      if (place.seen) places.shown[i] = Shown::kSeen;
      heights[i++] = place.height;
    }
  if (hidden_.MayHide(grid.BoundsOf(window))) MarkHidden(grid, window, heights, &places);
  return places;
}

// In steps of half the surface's cells: it has no finer detail.
void Rectifier::MarkHidden(const MapGrid& grid, const PixelWindow& window,
                           const std::vector<double>& heights, Places* places) const {
  const int step = std::max(1, static_cast<int>(0.5 * surface_.CellAlongX() / grid.gsd_m));
  const auto index = [&](int col, int row) {
    return static_cast<std::size_t>(row) * window.width + col;
  };
  // Blocks begin at multiples of the step, whatever the window.
  for (int top = -(window.row % step); top < window.height; top += step)
    for (int left = -(window.col % step); left < window.width; left += step) {
      const int row = std::clamp(top + step / 2, 0, window.height - 1);
      const int col = std::clamp(left + step / 2, 0, window.width - 1);
      if (places->shown[index(col, row)] == Shown::kNothing) continue;
      const Vector2d at = grid.GroundFromPixel(window.col + col + 0.5, window.row + row + 0.5);
      if (!hidden_.Hides({at.x(), at.y(), heights[index(col, row)]})) continue;
      for (int r = std::max(top, 0); r < std::min(top + step, window.height); ++r)
        for (int c = std::max(left, 0); c < std::min(left + step, window.width); ++c)
          if (Shown& shown = places->shown[index(c, r)]; shown == Shown::kSeen)
            shown = Shown::kHidden;
    }
}

// Where pixels on the ground are much larger than the scan's, a tile shows much of the scan: it is
// drawn in quarters.
OrthoTile Rectifier::Quartered(const MapGrid& grid, const PixelWindow& window) const {
  OrthoTile tile{window,
                 std::vector<Image>(static_cast<std::size_t>(scan_.Format().bands),
                                    Image(window.width, window.height)),
                 std::vector<Shown>(SizeOf(window), Shown::kNothing)};
  const int width = (window.width + 1) / 2, height = (window.height + 1) / 2;
  for (int top = 0; top < window.height; top += height)
    for (int left = 0; left < window.width; left += width) {
      const OrthoTile part =
          Draw(grid, {window.col + left, window.row + top, std::min(width, window.width - left),
                      std::min(height, window.height - top)});
      for (int row = 0; row < part.window.height; ++row)
        for (int col = 0; col < part.window.width; ++col) {
          const std::size_t from = static_cast<std::size_t>(row) * part.window.width + col;
          const std::size_t to = static_cast<std::size_t>(top + row) * window.width + left + col;
          tile.shown[to] = part.shown[from];
          for (std::size_t band = 0; band < tile.values.size(); ++band)
            tile.values[band].values[to] = part.values[band].values[from];
        }
    }
  return tile;
}

OrthoTile Rectifier::Draw(const MapGrid& grid, const PixelWindow& window) const {
  const Places places = PlacesOf(grid, window);
  OrthoTile tile{window, {}, places.shown};
  const double factor = Reduction(places, window);
  const PixelWindow from = ScanWindow(places, factor, scan_);
  if (static_cast<double>(from.width) * from.height * scan_.Format().bands > most_values_ &&
      window.width * window.height > 1)
    return Quartered(grid, window);
  tile.values.assign(static_cast<std::size_t>(scan_.Format().bands),
                     Image(window.width, window.height));
  if (from.width <= 0 || from.height <= 0) {
    std::replace(tile.shown.begin(), tile.shown.end(), Shown::kSeen, Shown::kNothing);
    return tile;
  }
  const double scale = factor > kAverage ? factor : 1;
  std::vector<Image> parts = scan_.ReadWithGaps(from);
  for (std::size_t band = 0; band < parts.size(); ++band) {
    const Image part = scale > 1 ? ReduceBy(parts[band], scale) : std::move(parts[band]);
    Image& values = tile.values[band];
    for (std::size_t i = 0; i < tile.shown.size(); ++i) {
      if (places.shown[i] != Shown::kSeen) continue;
      const float value =
          SampleBicubic(part, (places.scan_px[i] - Vector2d(from.col, from.row)) / scale);
      if (std::isfinite(value))
        values.values[i] = Clamped(scan_.Format(), value, negative_);
      else
        tile.shown[i] = Shown::kNothing;  // beside the scan, or in a gap
    }
  }
  return tile;
}

std::optional<Bounds> ShownGround(const PhotoView& view, const GroundSurface& surface) {
  const auto most =
      FootprintBounds(view.camera, view.pose, surface.MinHeight(), surface.MaxHeight());
  const Bounds extent = surface.Extent();
  Bounds shown = most.value_or(extent);
  const std::vector<Vector3d> outline = Footprint(view, surface);
  if (!outline.empty()) {
    Bounds seen = Bounds::OfNothing();
    for (const Vector3d& point : outline) seen.Include(point.x(), point.y());
    // Between the outline's points, relief may extend beyond it.
    const double margin = 0.05 * std::max(seen.max_x - seen.min_x, seen.max_y - seen.min_y);
    shown = {std::max(shown.min_x, seen.min_x - margin), std::max(shown.min_y, seen.min_y - margin),
             std::min(shown.max_x, seen.max_x + margin),
             std::min(shown.max_y, seen.max_y + margin)};
  }
  shown = {std::max(shown.min_x, extent.min_x), std::max(shown.min_y, extent.min_y),
           std::min(shown.max_x, extent.max_x), std::min(shown.max_y, extent.max_y)};
  if (shown.Empty()) return std::nullopt;
  return shown;
}

}  // namespace orient::ortho
