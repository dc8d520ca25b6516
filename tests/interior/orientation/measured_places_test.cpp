#include "interior/orientation/measured_places.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

CrossElement Cross() {
  CrossElement cross;
  cross.length_mm = 2;
  cross.width_mm = 0.1;
  return cross;
}

MarkShape ShapeOf(std::vector<MarkElement> elements) {
  MarkShape shape;
  shape.drawing.elements = std::move(elements);
  return shape;
}

Matrix2d Turn(double quarters) {
  return Eigen::Rotation2Dd(quarters * std::numbers::pi / 2).toRotationMatrix();
}

TEST(IsSymmetric, KnowsWhatTurnsIntoItself) {
  const MarkShape cross = ShapeOf({Cross()});
  EXPECT_TRUE(IsSymmetric(cross, Turn(1)));
  EXPECT_TRUE(IsSymmetric(cross, Vector2d(1, -1).asDiagonal()));
  EXPECT_FALSE(IsSymmetric(cross, Turn(0.5)));
  DotElement beside;
  beside.diameter_mm = 0.1;
  beside.at_mm = Vector2d(0.5, 0.5);
  EXPECT_FALSE(IsSymmetric(ShapeOf({Cross(), beside}), Turn(1)));
}

TEST(MeasuredPlaces, AreFoundWhereTheDrawingIsTheSame) {
  const MarkShape cross = ShapeOf({Cross()}), other = cross;
  const Matrix2d pixel_from_mm = 40 * Matrix2d::Identity();
  const Vector2d start(100.5, 30);
  FilmMark mark;
  mark.state = MarkState::kUsed;
  mark.position = MarkPosition{{101, 31}};
  MeasuredPlaces places;
  places.Add({&cross, pixel_from_mm, start, Polarity::kPositive}, mark);
  const auto find = [&](const MarkShape& shape, const Matrix2d& seen, const Vector2d& from,
                        Polarity polarity) {
    return places.Find({&shape, seen, from, polarity});
  };
  const FilmMark* found = find(cross, pixel_from_mm, start, Polarity::kPositive);
  ASSERT_NE(found, nullptr);
  EXPECT_EQ(found->position->pixel, Vector2d(101, 31));
  EXPECT_NE(find(cross, pixel_from_mm * Turn(1), start, Polarity::kPositive), nullptr);
  EXPECT_EQ(find(other, pixel_from_mm, start, Polarity::kPositive), nullptr);
  EXPECT_EQ(find(cross, 1.01 * pixel_from_mm, start, Polarity::kPositive), nullptr);
  EXPECT_EQ(find(cross, pixel_from_mm, start + Vector2d(0, 1), Polarity::kPositive), nullptr);
  EXPECT_EQ(find(cross, pixel_from_mm, start, Polarity::kNegative), nullptr);
}

TEST(MeasuredPlaces, AreNotFoundWhereADrawingIsTurnedIntoAnother) {
  WedgeElement notch;
  notch.base_mm = 0.4;
  notch.depth_mm = 0.6;
  const MarkShape wedge = ShapeOf({notch});
  MeasuredPlaces places;
  places.Add({&wedge, Matrix2d::Identity(), {0, 0}, Polarity::kPositive}, {});
  EXPECT_NE(places.Find({&wedge, Matrix2d::Identity(), {0, 0}, Polarity::kPositive}), nullptr);
  EXPECT_EQ(places.Find({&wedge, Turn(1), {0, 0}, Polarity::kPositive}), nullptr);
}

}  // namespace
}  // namespace orient::interior
