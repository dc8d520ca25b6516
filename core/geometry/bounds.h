// An upright rectangle on the ground, in metres of the block's CRS.
#pragma once

#include <algorithm>
#include <limits>

namespace orient {

struct Bounds {
  double min_x = 0, min_y = 0, max_x = 0, max_y = 0;

  // Of no point at all; Include makes it those of some.
  static Bounds OfNothing() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    return {kInfinity, kInfinity, -kInfinity, -kInfinity};
  }
  // Grows so far that the point lies inside.
  void Include(double x, double y) {
    min_x = std::min(min_x, x);
    min_y = std::min(min_y, y);
    max_x = std::max(max_x, x);
    max_y = std::max(max_y, y);
  }
  bool Empty() const { return min_x >= max_x || min_y >= max_y; }
  bool Contains(double x, double y) const {
    return x >= min_x && x <= max_x && y >= min_y && y <= max_y;
  }
  // They overlap in an area; a common edge does not count.
  bool Overlaps(const Bounds& other) const {
    return min_x < other.max_x && other.min_x < max_x && min_y < other.max_y && other.min_y < max_y;
  }
};

}  // namespace orient
