#include "interior/marks/matching_drawing.h"

#include <gtest/gtest.h>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kBlurPx = 0.6;

MarkShape Cross(double width_mm) {
  CrossElement cross;
  cross.length_mm = 1.5;
  cross.width_mm = width_mm;
  MarkShape shape;
  shape.drawing.elements = {cross};
  return shape;
}

// Drawn in pixels a ninth as large, blurred and then averaged; its centre is `off` beyond that of
// the middle pixel.
Image Scanned(const MarkShape& shape, const Matrix2d& pixel_from_mm, const Vector2d& off) {
  constexpr int kFinest = 9;
  RenderOptions render;
  render.blur_sigma_px = kFinest * kBlurPx;
  render.margin_mm = 0.7;
  render.supersampling = 2;
  render.offset_px = kFinest * off;
  render.smooth_outlines = true;
  render.whole_square = true;
  const Image finest = RenderMark(shape, kFinest * pixel_from_mm, render).values;
  const int first = finest.width / 2 - kFinest / 2;  // of the middle pixel
  const int half = first / kFinest, side = 2 * half + 1;
  Image scan(side, side);
  for (int row = 0; row < kFinest * side; ++row)
    for (int col = 0; col < kFinest * side; ++col)
      scan.At(col / kFinest, row / kFinest) +=
          finest.At(col + first - kFinest * half, row + first - kFinest * half) /
          static_cast<float>(kFinest * kFinest);
  return scan;
}

// Strokes of 4 and 1.6 pixels along the pixels' rows look other in every place within a pixel.
TEST(MatchingDrawing, IsFoundToATenthOfAHundredthOfAPixel) {
  const Matrix2d pixel_from_mm = Vector2d(40, -40).asDiagonal();
  for (const double width_mm : {0.1, 0.04}) {
    const MarkShape shape = Cross(width_mm);
    const MatchingDrawing drawing(shape, pixel_from_mm);
    const auto& level = drawing.Fine(MatchingDrawing::StepOf(kBlurPx));
    for (const Vector2d& off : {Vector2d(0.5, 0.25), Vector2d(-0.13, 0.38)}) {
      const Image scan = Scanned(shape, pixel_from_mm, off);
      const Vector2d middle = Vector2d::Constant(0.5 * scan.width);
      ImageWindow mark = drawing.CutOut(scan, middle);
      mark.image = RemoveBackground(mark.image, drawing.BackgroundPx());
      const SeenPlane seen(PutInPlace(mark, scan.width, scan.height));
      const auto match = level.moving.Match(seen, middle, 1);
      ASSERT_TRUE(match);
      EXPECT_LT((match->centre - middle - off).cwiseAbs().maxCoeff(), 0.001) << width_mm;
      EXPECT_GT(match->correlation, 0.999);
    }
  }
}

TEST(MatchingDrawing, KeepsItsLevels) {
  const MatchingDrawing drawing(Cross(0.1), Vector2d(40, -40).asDiagonal());
  const int step = MatchingDrawing::StepOf(0.8);
  EXPECT_NEAR(drawing.Fine(step).blur_px, 0.8, 0.01);
  EXPECT_EQ(&drawing.Fine(step), &drawing.Fine(step));
  EXPECT_LT(drawing.Fine(step - 1).blur_px, drawing.Fine(step).blur_px);
}

}  // namespace
}  // namespace orient::interior
