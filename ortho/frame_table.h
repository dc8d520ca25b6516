// Where the rays through a photo's frame lie in its scan, tabulated: lens, film and scan at once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/terrain/photo_view.h"

namespace orient::ortho {

// Bilinear between some 500 by 500 nodes over the frame: distortions bend so little from one to the
// next that the error stays below 0.02 px, for a hundredth of the time that a lens's polynomial and
// a film's correction take.
class FrameTable {
 public:
  // Nothing within `border_mm` of the frame's edge is seen, nor in `marks` (photo system, mm).
  FrameTable(const PhotoView& view, double border_mm, std::vector<Bounds> marks = {});

  // Scan pixel of an ideal image point, i.e. of the central projection -c d0/d2, -c d1/d2 (mm, from
  // the principal point); empty outside the frame.
  std::optional<Eigen::Vector2d> PixelOf(const Eigen::Vector2d& ideal_mm) const;

 private:
  struct Node {
    Eigen::Vector2d photo_mm, pixel;
    bool inner = false;  // all of the cell to its lower right is seen
  };

  bool Seen(const Eigen::Vector2d& photo_mm) const;
  void FindInnerCells();

  Bounds within_;  // of the photo system: the frame without its border
  std::vector<Bounds> marks_;
  Eigen::Vector2d origin_mm_, step_mm_;
  std::vector<Node> nodes_;  // row by row
};

}  // namespace orient::ortho
