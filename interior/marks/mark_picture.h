// The marks as a person wants to see them: every mark enlarged with the found centre drawn in, or
// with its drawing laid over it.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

// RGB, row-major, three bytes a pixel; as WritePng takes it.
struct Picture {
  int width = 0;
  int height = 0;
  std::vector<unsigned char> rgb;
};

// Empty columns between two tiles. Tiles are squares as high as the picture.
inline constexpr int kMarkTileGap = 4;

// One tile a mark, in the order of the result, side by side: `reach_mm` around the mark (radius of
// the drawing and a little more), stretched in contrast, an open cross at the found centre: green
// where the mark is used, orange where it is rejected. A missing mark's tile shows the place where
// the transform expects it, without a cross; it is grey where there is no transform.
Picture DrawMarks(const Raster& scan, const InteriorResult& result,
                  const std::vector<Eigen::Vector2d>& photo_mm, double pixel_mm, double reach_mm);

// A mark whose drawing is to be held against the scan.
struct DrawnMark {
  std::string id;
  MarkShape shape;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // its centre on the scan, found or expected
  bool found = true;
};

// One column a mark, three tiles high, named by the mark's id: the scan, the scan with the outline
// of the drawing's elements (green where the mark was found, orange where it is only expected), and
// the drawing as such a scanner would see it. `negative`: of the scan.
Picture DrawDrawings(const Raster& scan, const std::vector<DrawnMark>& marks,
                     const Eigen::Matrix2d& pixel_from_mm, bool negative);

}  // namespace orient::interior
