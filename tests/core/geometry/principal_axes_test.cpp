#include "core/geometry/principal_axes.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

double Between(int low, int high) { return *rc::gen::inRange(low, high) * 1e-3; }

TEST(PrincipalAxes, GiveTheMatrixBack) {
  EXPECT_TRUE(rc::check([] {
    const double small = Between(0, 1000), large = small + Between(0, 100000);
    const Matrix2d turn = Eigen::Rotation2Dd(Between(-3200, 3200)).toRotationMatrix();
    const Matrix2d matrix = turn * Vector2d(large, small).asDiagonal() * turn.transpose();
    const PrincipalAxes axes = AxesOf(matrix);
    const double tolerance = 1e-12 * std::max(large, 1.0);
    RC_ASSERT(std::abs(axes.values[0] - small) <= tolerance);
    RC_ASSERT(std::abs(axes.values[1] - large) <= tolerance);
    RC_ASSERT((axes.vectors.transpose() * axes.vectors - Matrix2d::Identity()).norm() < 1e-12);
    const Matrix2d back = axes.vectors * axes.values.asDiagonal() * axes.vectors.transpose();
    RC_ASSERT((back - matrix).norm() <= tolerance);
  }));
}

TEST(Thickness, IsTheRatioOfASmallTriangle) {
  EXPECT_NEAR(Thickness({{-2, 0}, {2, 0}, {0, 1}, {0, -1}}), 0.5, 1e-12);
}

TEST(Thickness, DoesNotDependOnPlaceTurnAndSize) {
  const std::vector<Vector2d> points = {{0, 0}, {7, 1}, {3, 4}, {-2, 2}};
  const double thickness = Thickness(points);
  EXPECT_TRUE(rc::check([&] {
    const Vector2d shift(Between(-100000, 100000), Between(-100000, 100000));
    const Matrix2d turn =
        Between(1, 10000) * Eigen::Rotation2Dd(Between(-3200, 3200)).toRotationMatrix();
    std::vector<Vector2d> moved;
    for (const Vector2d& point : points) moved.emplace_back(turn * point + shift);
    RC_ASSERT(std::abs(Thickness(moved) - thickness) < 1e-5);
  }));
}

TEST(Thickness, OfPointsOnOneLineIsZero) {
  EXPECT_LT(Thickness({{-106, -106}, {0, 0}, {3, 3}, {106, 106}}), 1e-7);
}

TEST(Thickness, OfOnePlaceOrNoneIsZero) {
  EXPECT_EQ(Thickness({}), 0);
  EXPECT_EQ(Thickness({{5, 5}}), 0);
  EXPECT_EQ(Thickness({{5, 5}, {5, 5}}), 0);
}

}  // namespace
}  // namespace orient
