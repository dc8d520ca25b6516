#include "core/geometry/rotation.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "tests/support/generators.h"

namespace orient {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kExact = 1e-12;

TEST(Rotation, EqualsTheProductOfThreeTurns) {
  const Eigen::Vector3d opk(0.3, -0.7, 2.1);
  const Eigen::Matrix3d product = (Eigen::AngleAxisd(opk[0], Eigen::Vector3d::UnitX()) *
                                   Eigen::AngleAxisd(opk[1], Eigen::Vector3d::UnitY()) *
                                   Eigen::AngleAxisd(opk[2], Eigen::Vector3d::UnitZ()))
                                      .toRotationMatrix();
  EXPECT_LT((GroundFromPhotoRotation(opk) - product).norm(), kExact);
}

TEST(Rotation, KappaTurnsThePhotoCounterClockwise) {
  // Kappa = 90 degrees: the photo's x axis points to the north.
  const Eigen::Matrix3d r = GroundFromPhotoRotation({0, 0, kPi / 2});
  EXPECT_LT((r * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), kExact);
}

TEST(Rotation, PositiveOmegaLooksToTheNorth) {
  // The view direction is -z of the photo.
  const Eigen::Vector3d view = GroundFromPhotoRotation({0.1, 0, 0}) * Eigen::Vector3d(0, 0, -1);
  EXPECT_GT(view.y(), 0.09);
}

TEST(Rotation, PositivePhiLooksToTheWest) {
  const Eigen::Vector3d view = GroundFromPhotoRotation({0, 0.1, 0}) * Eigen::Vector3d(0, 0, -1);
  EXPECT_LT(view.x(), -0.09);
}

TEST(Rotation, AnglesComeBack) {
  EXPECT_TRUE(rc::check("opk -> R -> opk", [] {
    const Eigen::Vector3d opk(*InRange(-kPi, kPi), *InRange(-1.57, 1.57), *InRange(-kPi, kPi));
    const Eigen::Vector3d back = OpkFromRotation(GroundFromPhotoRotation(opk));
    for (int i = 0; i < 3; ++i)
      RC_ASSERT(std::abs(NormalizeAngle(back[i] - opk[i])) < kExact / std::cos(opk[1]));
  }));
}

TEST(Rotation, RotationsComeBackEvenBesideTheGimbalLock) {
  EXPECT_TRUE(rc::check("R -> opk -> R", [] {
    const double beside = std::pow(10, -*InRange(1, 17));
    const Eigen::Vector3d opk(*InRange(-kPi, kPi), kPi / 2 - beside, *InRange(-kPi, kPi));
    const Eigen::Matrix3d r = GroundFromPhotoRotation(opk);
    RC_ASSERT((GroundFromPhotoRotation(OpkFromRotation(r)) - r).norm() < kExact);
  }));
}

TEST(Rotation, GimbalLockGivesOmegaZero) {
  for (const double sign : {1.0, -1.0}) {
    const Eigen::Matrix3d r = GroundFromPhotoRotation({0.4, sign * kPi / 2, 1.1});
    const Eigen::Vector3d opk = OpkFromRotation(r);
    EXPECT_EQ(opk[0], 0);
    EXPECT_NEAR(opk[1], sign * kPi / 2, kExact);
    EXPECT_NEAR(opk[2], 1.1 + sign * 0.4, kExact);
    EXPECT_LT((GroundFromPhotoRotation(opk) - r).norm(), kExact);
  }
}

TEST(Rotation, HalfTurnsComeOutPositive) {
  EXPECT_EQ(NormalizeAngle(-kPi), kPi);
  EXPECT_EQ(NormalizeAngle(kPi), kPi);
  EXPECT_EQ(NormalizeAngle(3 * kPi), kPi);
  EXPECT_NEAR(NormalizeAngle(2 * kPi + 0.25), 0.25, kExact);
  const Eigen::Matrix3d half_turn = Eigen::Vector3d(-1, -1, 1).asDiagonal();
  EXPECT_EQ(OpkFromRotation(half_turn)[2], kPi);
  const Eigen::Matrix3d upside_down = Eigen::Vector3d(1, -1, -1).asDiagonal();
  EXPECT_EQ(OpkFromRotation(upside_down)[0], kPi);
}

TEST(Rotation, DegreesAndRadians) {
  EXPECT_DOUBLE_EQ(RadFromDeg(180), kPi);
  EXPECT_DOUBLE_EQ(DegFromRad(kPi / 2), 90);
}

}  // namespace
}  // namespace orient
