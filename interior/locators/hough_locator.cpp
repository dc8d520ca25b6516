#include "interior/locators/hough_locator.h"

#include <Eigen/LU>
#include <cmath>

#include "interior/locators/template_search.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// The neighbourhood: pixels between these distances from a stroke's edge.
constexpr double kNearPx = 1.5, kFarPx = 2.5;

// Is the stroke's middle line within half a pixel? A step of one pixel away from the nearest edge
// then leads across it.
bool OnMiddleLine(const MarkDrawing& drawing, const Vector2d& at_mm, double pixel_mm) {
  const double distance = StrokeDistance(drawing, at_mm);
  if (distance >= 0.5 * pixel_mm) return false;
  const double h = 0.1 * pixel_mm;
  const auto slope = [&](const Vector2d& step) {
    return StrokeDistance(drawing, at_mm + step) - StrokeDistance(drawing, at_mm - step);
  };
  const Vector2d outwards(slope({h, 0}), slope({0, h}));
  constexpr double kRidge = 0.5;  // on it both edges are equally near: no direction is outwards
  if (outwards.norm() < kRidge * 2 * h) return true;
  return StrokeDistance(drawing, at_mm - pixel_mm * outwards.normalized()) >= distance;
}

}  // namespace

MarkTemplate SkeletonTemplate(const MarkShape& shape, const Matrix2d& pixel_from_mm) {
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  const double pixel_mm = std::sqrt(std::abs(mm_from_pixel.determinant()));
  const int half = static_cast<int>(std::ceil(1.03 * MarkRadius(shape) / pixel_mm + kFarPx + 0.5));
  MarkTemplate result;
  result.values = Image(2 * half + 1, 2 * half + 1, kNoData);
  result.centre = Vector2d::Constant(half + 0.5);
  for (int row = 0; row < result.values.height; ++row) {
    for (int col = 0; col < result.values.width; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - result.centre);
      const double outside_px = StrokeDistance(shape.drawing, mm) / pixel_mm;
      if (outside_px >= kNearPx && outside_px < kFarPx)
        result.values.At(col, row) = 0;
      else if (OnMiddleLine(shape.drawing, mm, pixel_mm))
        result.values.At(col, row) = 1;
    }
  }
  return result;
}

MarkCandidates HoughLocator::Find(ScanWindows& scan, const MarkShape& shape,
                                  const MarkSearch& search) const {
  if (shape.picture) return {};
  return search_.Find(scan, shape, search, [&](const Matrix2d& pixel_from_mm) {
    return SkeletonTemplate(shape, pixel_from_mm);
  });
}

}  // namespace orient::interior
