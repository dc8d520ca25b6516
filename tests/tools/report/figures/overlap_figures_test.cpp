#include "tools/report/figures/overlap_figures.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

OverlapCounts::Outline Square(double west, double side) {
  return {{west, 0}, {west + side, 0}, {west + side, side}, {west, side}};
}

TEST(OverlapFigures, SharesAreOfTheCoveredGround) {
  const OverlapCounts counts({Square(0, 100), Square(50, 100)});
  EXPECT_NEAR(counts.Share(1), 2 / 3.0, 0.01);
  EXPECT_NEAR(counts.Share(2), 1 / 3.0, 0.01);
  EXPECT_EQ(counts.Share(3), 0);
}

TEST(OverlapFigures, MoreThanTheMostAreCountedTogether) {
  const OverlapCounts counts(std::vector<OverlapCounts::Outline>(9, Square(0, 10)));
  EXPECT_EQ(counts.Share(OverlapCounts::kMostCounted), 1);
}

}  // namespace
}  // namespace orient
