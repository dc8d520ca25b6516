#include "core/geometry/pose.h"

#include <gtest/gtest.h>

#include <numbers>

namespace orient {
namespace {

constexpr double kPi = std::numbers::pi;

TEST(PoseDifference, IsWhatMustBeAdded) {
  const Pose from{{1000, 2000, 3000}, {0.1, -0.2, 1.0}}, to{{1010, 1980, 3030}, {0.0, 0.1, 1.5}};
  Vector6d expected;
  expected << 10, -20, 30, -0.1, 0.3, 0.5;
  EXPECT_LT((PoseDifference(to, from) - expected).norm(), 1e-12);
  EXPECT_LT((PoseDifference(from, to) + expected).norm(), 1e-12);
}

TEST(PoseDifference, OfAnglesIsTheShortWayRound) {
  const Pose from{{0, 0, 0}, {0, 0, kPi - 0.1}}, to{{0, 0, 0}, {0, 0, 0.1 - kPi}};
  EXPECT_NEAR(PoseDifference(to, from)[5], 0.2, 1e-12);
  EXPECT_NEAR(PoseDifference(from, to)[5], -0.2, 1e-12);
}

}  // namespace
}  // namespace orient
