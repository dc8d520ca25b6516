#include "interior/mark_drawing.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/imaging/correlation.h"
#include "tests/support/film_frame.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Supersampling 6 x 6 leaves about this much of a stroke's area undecided.
constexpr double kAreaTolerance = 0.01;

Matrix2d Upright(double pixels_per_mm) {
  return Eigen::DiagonalMatrix<double, 2>(pixels_per_mm, -pixels_per_mm);
}

double Sum(const Image& image) {
  double sum = 0;
  for (const float v : image.values)
    if (!std::isnan(v)) sum += static_cast<double>(v);
  return sum;
}

MarkShape Shape(std::vector<MarkElement> elements) {
  MarkShape shape;
  shape.drawing.elements = std::move(elements);
  return shape;
}

TEST(StrokeDistance, IsNegativeInsideAndMillimetresOutside) {
  const MarkShape ring = Shape({CircleElement{2.0, 0.2}});
  EXPECT_NEAR(StrokeDistance(ring.drawing, {1.0, 0}), -0.1, 1e-12);
  EXPECT_NEAR(StrokeDistance(ring.drawing, {0, 2.0}), 0.9, 1e-12);
  EXPECT_NEAR(StrokeDistance(ring.drawing, {0, 0}), 0.9, 1e-12);
  const MarkShape cross = Shape({CrossElement{4.0, 0.2, 1.0, 0}});
  EXPECT_NEAR(StrokeDistance(cross.drawing, {1.0, 0}), -0.1, 1e-12);
  EXPECT_NEAR(StrokeDistance(cross.drawing, {0, -2.5}), 0.5, 1e-12);
  EXPECT_GT(StrokeDistance(cross.drawing, {0, 0}), 0.0);  // the gap is open
}

TEST(RenderMark, CoversTheStrokesArea) {
  const double pi = std::numbers::pi;
  const double ppm = 20;
  const auto area = [&](const MarkShape& s) {
    return Sum(RenderMark(s, Upright(ppm), {0.8, 0.5}).values) / (ppm * ppm);
  };
  EXPECT_NEAR(area(Shape({DotElement{1.0}})), pi / 4, kAreaTolerance);
  EXPECT_NEAR(area(Shape({CircleElement{2.0, 0.2}})), pi * 2.0 * 0.2, kAreaTolerance);
  EXPECT_NEAR(area(Shape({CrossElement{4.0, 0.2, 1.0, 0.3}})), 2 * 0.2 * 3.0, kAreaTolerance);
}

TEST(RenderMark, IsCentredForAnyTurn) {
  const MarkShape shape = Shape({CrossElement{3.5, 0.13, 0.5, 0.7}, CircleElement{1.7, 0.2}});
  for (const double turn : {0.0, 0.4, 1.1}) {
    const MarkTemplate t =
        RenderMark(shape, Eigen::Rotation2Dd(turn).toRotationMatrix() * Upright(9));
    Vector2d moment = Vector2d::Zero();
    for (int r = 0; r < t.values.height; ++r)
      for (int c = 0; c < t.values.width; ++c)
        if (!std::isnan(t.values.At(c, r)))
          moment +=
              static_cast<double>(t.values.At(c, r)) * (Vector2d(c + 0.5, r + 0.5) - t.centre);
    EXPECT_LT(moment.norm() / Sum(t.values), 1e-4) << turn;
  }
}

TEST(RenderMark, TurnsAndMirrorsTheDrawing) {
  // A picture without any symmetry: bright quarter at the upper right, brighter bar at the left.
  MarkShape shape;
  shape.drawing.image = MarkImage{"", 0.1, {20, 20}};
  shape.picture = Image(40, 40, 0.0f);
  for (int r = 5; r < 15; ++r)
    for (int c = 25; c < 35; ++c) shape.picture->At(c, r) = 1.0f;
  // 1.0 mm right and 1.0 mm up in the mark system is right and up when upright.
  const auto value = [&](const Matrix2d& pixel_from_mm, double right_px, double down_px) {
    const MarkTemplate t = RenderMark(shape, pixel_from_mm, {0.0, 0.0});
    return t.values.At(static_cast<int>(t.centre.x() + right_px),
                       static_cast<int>(t.centre.y() + down_px));
  };
  const Matrix2d upright = Upright(10);
  EXPECT_NEAR(value(upright, 10, -10), 1.0, 1e-6);
  // Turned counter-clockwise by 90 degrees it is left and up, mirrored left and up, too.
  const Matrix2d r90 = PhotoFromPixelAxes(ScanOrientation::kR90).transpose() * 10;
  EXPECT_NEAR(value(r90, -10, -10), 1.0, 1e-6);
  EXPECT_NEAR(value(r90, 10, 10), 0.0, 1e-6);
  const Matrix2d m0 = PhotoFromPixelAxes(ScanOrientation::kM0).transpose() * 10;
  EXPECT_NEAR(value(m0, -10, -10), 1.0, 1e-6);
  EXPECT_NEAR(value(m0, 10, -10), 0.0, 1e-6);
}

TEST(RenderMark, RefusesASingularTransformAndAnEmptyDrawing) {
  EXPECT_THROW(RenderMark(Shape({DotElement{1}}), Matrix2d::Zero()), std::invalid_argument);
  EXPECT_THROW(RenderMark(Shape({}), Upright(10)), std::invalid_argument);
  MarkShape without_picture;
  without_picture.drawing.image = MarkImage{"mark.png", 0.1, {20, 20}};
  EXPECT_THROW(RenderMark(without_picture, Upright(10)), std::invalid_argument);
}

TEST(LooksSame, KnowsADrawingsSymmetry) {
  const Matrix2d quarter = Eigen::Rotation2Dd(std::numbers::pi / 2).toRotationMatrix();
  const Matrix2d mirror = Eigen::DiagonalMatrix<double, 2>(-1, 1);
  const MarkShape ring{RingCamera().marks.at("corner"), std::nullopt};
  EXPECT_TRUE(LooksSame(ring, quarter));
  EXPECT_TRUE(LooksSame(ring, mirror));
  const MarkShape tilted = Shape({CrossElement{3, 0.15, 0, 0.3}});
  EXPECT_TRUE(LooksSame(tilted, quarter));
  EXPECT_FALSE(LooksSame(tilted, mirror));
}

TEST(MarkRadius, ReachesTheFarthestStroke) {
  EXPECT_NEAR(MarkRadius(Shape({CircleElement{2.0, 0.2}, DotElement{0.1}})), 1.1, 1e-12);
  EXPECT_NEAR(ThinnestStroke(Shape({CircleElement{2.0, 0.2}, DotElement{0.1}})), 0.1, 1e-12);
}

}  // namespace
}  // namespace orient
