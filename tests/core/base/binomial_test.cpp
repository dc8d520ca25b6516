#include "core/base/binomial.h"

#include <gtest/gtest.h>

#include <cmath>

namespace orient {
namespace {

TEST(UpperBoundOfRate, IsCertaintyWhereNothingWasTriedOrAllWasFound) {
  EXPECT_EQ(UpperBoundOfRate(0, 0, 0.001), 1);
  EXPECT_EQ(UpperBoundOfRate(50, 50, 0.001), 1);
}

// (1 - p)^n = 0.001.
TEST(UpperBoundOfRate, OfNoneFoundIsInClosedForm) {
  EXPECT_NEAR(UpperBoundOfRate(0, 100, 0.001), 1 - std::pow(0.001, 0.01), 1e-9);
  EXPECT_NEAR(UpperBoundOfRate(0, 1, 0.001), 0.999, 1e-9);
}

TEST(UpperBoundOfRate, GrowsWithWhatIsFoundAndFallsWithWhatIsTried) {
  EXPECT_LT(UpperBoundOfRate(5, 100, 0.001), UpperBoundOfRate(10, 100, 0.001));
  EXPECT_LT(UpperBoundOfRate(10, 200, 0.001), UpperBoundOfRate(5, 100, 0.001));
  EXPECT_GT(UpperBoundOfRate(10, 200, 0.001), 0.05);
}

}  // namespace
}  // namespace orient
