// An upright rectangle on the ground, in metres of the block's CRS.
#pragma once

namespace orient {

struct Bounds {
  double min_x = 0, min_y = 0, max_x = 0, max_y = 0;
  bool Empty() const { return min_x >= max_x || min_y >= max_y; }
  bool Contains(double x, double y) const {
    return x >= min_x && x <= max_x && y >= min_y && y <= max_y;
  }
};

}  // namespace orient
