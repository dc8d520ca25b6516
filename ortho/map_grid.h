// The pixels of an orthophoto or a mosaic on the map.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/geometry/bounds.h"
#include "core/raster/image.h"

namespace orient::ortho {

// North up. Pixel borders lie at whole multiples of the pixel size in the map's coordinates, so the
// pixels of all grids of one size coincide: a mosaic takes them as they are.
struct MapGrid {
  double gsd_m = 1;
  std::int64_t west = 0, north = 0;  // outer corner of the first pixel, in pixels
  int width = 0, height = 0;

  // All pixels that touch the bounds.
  static MapGrid Around(const Bounds& bounds, double gsd_m) {
    MapGrid grid;
    grid.gsd_m = gsd_m;
    grid.west = std::llround(std::floor(bounds.min_x / gsd_m));
    grid.north = std::llround(std::ceil(bounds.max_y / gsd_m));
    grid.width = static_cast<int>(std::llround(std::ceil(bounds.max_x / gsd_m)) - grid.west);
    grid.height = static_cast<int>(grid.north - std::llround(std::floor(bounds.min_y / gsd_m)));
    return grid;
  }

  // All pixels of this grid and of another one of the same pixel size.
  MapGrid With(const MapGrid& other) const {
    MapGrid all = *this;
    all.west = std::min(west, other.west);
    all.north = std::max(north, other.north);
    all.width = static_cast<int>(std::max(west + width, other.west + other.width) - all.west);
    all.height = static_cast<int>(all.north - std::min(north - height, other.north - other.height));
    return all;
  }
  // The part of `window` (of this grid) that lies in `other`, in the other's pixels; width or
  // height is not positive where there is none.
  PixelWindow WindowIn(const MapGrid& other, const PixelWindow& window) const {
    const int right = static_cast<int>(west - other.west),
              down = static_cast<int>(other.north - north);
    const int left = std::max(window.col + right, 0), top = std::max(window.row + down, 0);
    return {left, top, std::min(window.col + right + window.width, other.width) - left,
            std::min(window.row + down + window.height, other.height) - top};
  }

  Eigen::Vector2d GroundFromPixel(double col, double row) const {
    return {gsd_m * (static_cast<double>(west) + col), gsd_m * (static_cast<double>(north) - row)};
  }
  Bounds BoundsOf(const PixelWindow& window) const {
    const Eigen::Vector2d upper = GroundFromPixel(window.col, window.row);
    const Eigen::Vector2d lower =
        GroundFromPixel(window.col + window.width, window.row + window.height);
    return {upper.x(), lower.y(), lower.x(), upper.y()};
  }
  Bounds AllBounds() const { return BoundsOf({0, 0, width, height}); }
  // GDAL's six numbers.
  std::array<double, 6> GeoTransform() const {
    const Eigen::Vector2d corner = GroundFromPixel(0, 0);
    return {corner.x(), gsd_m, 0, corner.y(), 0, -gsd_m};
  }
};

}  // namespace orient::ortho
