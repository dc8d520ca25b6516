#include "interior/marks/mark_drawing.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/matching/correlation.h"
#include "tests/support/film_frame.h"

namespace orient::interior {
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

// Of the brightness, from the mark's centre.
Vector2d Centroid(const MarkTemplate& t) {
  Vector2d moment = Vector2d::Zero();
  for (int r = 0; r < t.values.height; ++r)
    for (int c = 0; c < t.values.width; ++c)
      if (!std::isnan(t.values.At(c, r)))
        moment += static_cast<double>(t.values.At(c, r)) * (Vector2d(c + 0.5, r + 0.5) - t.centre);
  return moment / Sum(t.values);
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
    EXPECT_LT(Centroid(t).norm(), 1e-4) << turn;
  }
}

// Samples on a lattice place an outline to a sample's distance where it runs along the lattice.
TEST(RenderMark, PutsSmoothOutlinesWhereTheyAreInAllDirections) {
  constexpr double kWanted_px = 0.003;
  const MarkShape line = Shape({LineElement{{-0.5, 0}, {0.5, 0}, 0.1}});
  RenderOptions options;
  options.blur_sigma_px = 0;
  options.supersampling = 4;
  options.smooth_outlines = true;
  options.offset_px = {0.21, -0.37};
  for (const double turn : {0.0, 0.003, 0.25 * std::numbers::pi, 0.25 * std::numbers::pi + 0.003,
                            std::atan(0.5), 0.4}) {
    const Matrix2d pixel_from_mm = Eigen::Rotation2Dd(turn).toRotationMatrix() * Upright(40);
    const MarkTemplate t = RenderMark(line, pixel_from_mm, options);
    const Vector2d across = pixel_from_mm.col(1).normalized();
    EXPECT_LT(std::abs(across.dot(Centroid(t))), kWanted_px) << turn;
    EXPECT_NEAR(Sum(t.values) / 1600, 0.1, 2e-4) << turn;
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

double Number(double low, double high) {
  return low + (high - low) * *rc::gen::inRange(0, 1001) / 1000.0;
}
Vector2d Place(double reach) { return {Number(-reach, reach), Number(-reach, reach)}; }

MarkElement AnyElement() {
  const double brightness = Number(-1, 1);
  switch (*rc::gen::inRange(0, 7)) {
    case 0:
      return CrossElement{Number(2, 4), Number(0.1, 0.3), Number(0, 1.5),
                          Number(0, 1), Place(1),         brightness};
    case 1:
      return DotElement{Number(0.2, 2), Place(1), brightness};
    case 2:
      return CircleElement{Number(1, 3), Number(0.1, 0.3), Place(1), brightness};
    case 3:
      return LineElement{Place(2), Place(2) + Vector2d(5, 0), Number(0.1, 0.3), brightness};
    case 4:
      return WedgeElement{Number(0.5, 2), Number(0.5, 2), Number(0, 6), Place(1), brightness};
    case 5:
      return CheckerElement{Number(1, 3), Number(0, 1), Place(1), brightness};
    default:
      return PolygonElement{{Place(1), Vector2d(3, 0) + Place(1), Vector2d(1, 4)}, brightness};
  }
}

std::vector<MarkElement> AnyElements() {
  std::vector<MarkElement> elements(*rc::gen::inRange(1, 4));
  for (MarkElement& e : elements) e = AnyElement();
  return elements;
}

// What a shape is without looking at distances: its area, mm^2.
double AreaOf(const MarkElement& element) {
  const double pi = std::numbers::pi;
  if (const auto* dot = std::get_if<DotElement>(&element))
    return 0.25 * pi * dot->diameter_mm * dot->diameter_mm;
  if (const auto* circle = std::get_if<CircleElement>(&element))
    return pi * circle->diameter_mm * circle->width_mm;
  if (const auto* line = std::get_if<LineElement>(&element))
    return line->width_mm * (line->to_mm - line->from_mm).norm();
  if (const auto* wedge = std::get_if<WedgeElement>(&element))
    return 0.5 * wedge->base_mm * wedge->depth_mm;
  if (const auto* checker = std::get_if<CheckerElement>(&element))
    return 0.5 * checker->size_mm * checker->size_mm;
  if (const auto* polygon = std::get_if<PolygonElement>(&element)) {
    const auto& p = polygon->points_mm;  // AnyElement's triangles
    const Vector2d a = p[1] - p[0], b = p[2] - p[0];
    return 0.5 * std::abs(a.x() * b.y() - a.y() * b.x());
  }
  const auto& cross = std::get<CrossElement>(element);
  const double overlap = std::max(0.0, cross.width_mm - cross.gap_mm);  // of the arms' ends
  return 2 * cross.width_mm * (cross.length_mm - cross.gap_mm) - overlap * overlap;
}

// With smooth outlines: samples on a lattice would count or miss a whole row along a long stroke.
TEST(RenderMark, HoldsEveryShapesAreaTimesItsBrightness) {
  RenderOptions options{0.8, 0.5};
  options.smooth_outlines = true;
  EXPECT_TRUE(rc::check([&] {
    const MarkElement element = AnyElement();
    const double ppm = 20;
    const Matrix2d turn = Eigen::Rotation2Dd(Number(0, 6)).toRotationMatrix() * ppm;
    const double area = Sum(RenderMark(Shape({element}), turn, options).values) / (ppm * ppm);
    RC_ASSERT(std::abs(area - BrightnessOf(element) * AreaOf(element)) < kAreaTolerance);
  }));
}

// The template of a film that lies turned or mirrored is the turned or mirrored template.
TEST(RenderMark, CommutesWithTurningAndMirroringTheFilm) {
  EXPECT_TRUE(rc::check([] {
    const MarkShape shape = Shape(AnyElements());
    const Image upright = RenderMark(shape, Upright(8)).values;
    const Image turned =  // x to the right and y up become y to the right and x up
        RenderMark(shape, (Matrix2d() << 0, 8, -8, 0).finished()).values;
    const Image mirrored = RenderMark(shape, (Matrix2d() << -8, 0, 0, -8).finished()).values;
    const int last = upright.width - 1;
    RC_ASSERT(turned.width == upright.width && mirrored.width == upright.width);
    for (int row = 0; row <= last; ++row)
      for (int col = 0; col <= last; ++col) {
        const float a = upright.At(col, row);
        const float b = turned.At(last - row, last - col);
        const float c = mirrored.At(last - col, row);
        RC_ASSERT(std::isnan(a) == std::isnan(c) && std::isnan(a) == std::isnan(b));
        RC_ASSERT(std::isnan(a) || (std::abs(a - b) < 2e-3f && std::abs(a - c) < 2e-3f));
      }
  }));
}

TEST(RenderMark, PaintsLaterElementsOverEarlierOnes) {
  const MarkShape eye = Shape({DotElement{3.0}, DotElement{1.0, {0, 0}, -0.5}});
  const MarkTemplate t = RenderMark(eye, Upright(10), {0.0, 0.5});
  const int centre = static_cast<int>(t.centre.x());
  EXPECT_EQ(t.values.At(centre, centre), -0.5f);
  EXPECT_EQ(t.values.At(centre + 10, centre), 1.0f);
  EXPECT_EQ(t.values.At(centre, centre - 17), 0.0f);
  const MarkShape covered = Shape({DotElement{1.0, {0, 0}, -0.5}, DotElement{3.0}});
  EXPECT_EQ(RenderMark(covered, Upright(10), {0.0, 0.5}).values.At(centre, centre), 1.0f);
}

TEST(RenderMark, PutsAWedgesTipWhereItIsSaid) {
  const double right_angle = std::numbers::pi / 2;
  const MarkElement up = WedgeElement{2.0, 1.5, right_angle, {0.5, 1.0}};
  EXPECT_NEAR(SignedDistance(up, {0.5, 1.0}), 0, 1e-12);  // the tip
  EXPECT_LT(SignedDistance(up, {0.5, 0.9}), 0);
  EXPECT_GT(SignedDistance(up, {0.5, 1.1}), 0);
  EXPECT_LT(SignedDistance(up, {1.4, -0.45}), 0);  // in the base's corner
  EXPECT_NEAR(SignedDistance(up, {0.5, -1.5}), 1.0, 1e-12);
}

TEST(RenderMark, CheckersAreBrightAtTheUpperRightAndLowerLeft) {
  const MarkElement checker = CheckerElement{2.0};
  EXPECT_NEAR(SignedDistance(checker, {0.5, 0.5}), -0.5, 1e-12);
  EXPECT_NEAR(SignedDistance(checker, {-0.3, -0.5}), -0.3, 1e-12);
  EXPECT_NEAR(SignedDistance(checker, {0.5, -0.2}), 0.2, 1e-12);
  EXPECT_NEAR(SignedDistance(checker, {0, 0}), 0, 1e-12);
}

TEST(SignedDistance, OfAPolygonWithAHollowIsRight) {
  const MarkElement l = PolygonElement{{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}}};
  EXPECT_NEAR(SignedDistance(l, {2, 2}), 1, 1e-12);  // in the L's hollow
  EXPECT_NEAR(SignedDistance(l, {0.5, 2}), -0.5, 1e-12);
  EXPECT_NEAR(SignedDistance(l, {-3, -4}), 5, 1e-12);
}

// A notch in the straight edge of a picture, which is below: its outline as drawn, the picture's
// and the border's side of it.
class NotchInThePicturesEdge : public testing::Test {
 protected:
  // Of a template of 10 pixels a millimetre.
  static float At(const MarkTemplate& drawn, double x_mm, double y_mm) {
    const Vector2d pixel = drawn.centre + 10 * Vector2d(x_mm, -y_mm);
    return drawn.values.At(static_cast<int>(std::floor(pixel.x())),
                           static_cast<int>(std::floor(pixel.y())));
  }

  const MarkShape notch_ =
      Shape({PolygonElement{{{-2, 0}, {-0.7, 0}, {0, 1.4}, {0.7, 0}, {2, 0}}, 1, true}});
};

TEST_F(NotchInThePicturesEdge, HasNoOutlineWhereItIsOpen) {
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {-1, 0.3}), 0.3, 1e-12);
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {-1, -0.3}), -0.3, 1e-12);
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {0, 0}), -0.7 * 2 / std::sqrt(5), 1e-12);
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {0, -2.4}), -2.5, 1e-12);  // from both corners
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {6, 3}), 5, 1e-12);
  EXPECT_NEAR(StrokeDistance(notch_.drawing, {6, -3}), -5, 1e-12);
}

TEST_F(NotchInThePicturesEdge, IsDrawnAsFarAsItIsKnown) {
  const MarkTemplate drawn = RenderMark(notch_, Upright(10), {0.0, 0.4});
  EXPECT_EQ(At(drawn, 0, 0.5), 1.0f);
  EXPECT_EQ(At(drawn, -1.55, -0.25), 1.0f) << "the picture beside its edge";
  EXPECT_EQ(At(drawn, -1.55, 0.25), 0.0f) << "the border beside it";
  EXPECT_EQ(At(drawn, 2.15, -0.15), 1.0f) << "the edge goes on";
  EXPECT_EQ(At(drawn, 2.15, 0.15), 0.0f);
  EXPECT_TRUE(std::isnan(At(drawn, 0, -0.8))) << "the picture may show anything";
  EXPECT_TRUE(std::isnan(At(drawn, 0.9, 1.2)));
}

TEST(LooksSame, KnowsTheOtherShapes) {
  const Matrix2d quarter = Eigen::Rotation2Dd(std::numbers::pi / 2).toRotationMatrix();
  const Matrix2d half = -Matrix2d::Identity();
  const Matrix2d mirror = Eigen::DiagonalMatrix<double, 2>(-1, 1);
  const MarkShape checker = Shape({CheckerElement{3.0}});
  EXPECT_TRUE(LooksSame(checker, half));
  EXPECT_FALSE(LooksSame(checker, quarter));
  EXPECT_FALSE(LooksSame(checker, mirror));
  EXPECT_TRUE(LooksSame(checker, quarter * mirror));
  const MarkShape tooth = Shape({WedgeElement{1.4, 1.4, std::numbers::pi / 2}});
  EXPECT_TRUE(LooksSame(tooth, mirror));
  EXPECT_FALSE(LooksSame(tooth, quarter));
  EXPECT_FALSE(LooksSame(tooth, half));
  const MarkShape three_arms =
      Shape({LineElement{{0.5, 0}, {2, 0}, 0.15}, LineElement{{-0.5, 0}, {-2, 0}, 0.15},
             LineElement{{0, 0.5}, {0, 2}, 0.15}});
  EXPECT_TRUE(LooksSame(three_arms, mirror));
  EXPECT_FALSE(LooksSame(three_arms, half));
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

TEST(LooksSame, SeesStrokesHoweverThin) {
  const Matrix2d quarter = Eigen::Rotation2Dd(std::numbers::pi / 2).toRotationMatrix();
  const Matrix2d eighth = Eigen::Rotation2Dd(std::numbers::pi / 4).toRotationMatrix();
  for (const double width_mm : {0.02, 0.005}) {
    const MarkShape cross = Shape({CrossElement{2, width_mm, 0, 0}});
    EXPECT_TRUE(LooksSame(cross, Matrix2d::Identity())) << width_mm;
    EXPECT_TRUE(LooksSame(cross, quarter)) << width_mm;
    EXPECT_FALSE(LooksSame(cross, eighth)) << width_mm;
    const MarkShape line = Shape({LineElement{{-1, 0}, {1, 0}, width_mm}});
    EXPECT_FALSE(LooksSame(line, quarter)) << width_mm;
  }
}

TEST(MarkRadius, ReachesTheFarthestStroke) {
  EXPECT_NEAR(MarkRadius(Shape({CircleElement{2.0, 0.2}, DotElement{0.1}})), 1.1, 1e-12);
  EXPECT_NEAR(ThinnestStroke(Shape({CircleElement{2.0, 0.2}, DotElement{0.1}})), 0.1, 1e-12);
  EXPECT_NEAR(WidestStroke(Shape({CircleElement{2.0, 0.2}, DotElement{0.1}})), 0.2, 1e-12);
}

}  // namespace
}  // namespace orient::interior
