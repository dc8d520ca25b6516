#include "core/geometry/bounds.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(Bounds, OfNothingAreEmptyAndContainNothing) {
  EXPECT_TRUE(Bounds::OfNothing().Empty());
  EXPECT_FALSE(Bounds::OfNothing().Contains(0, 0));
}

TEST(Bounds, ReachJustAsFarAsThePointsTheyInclude) {
  Bounds bounds = Bounds::OfNothing();
  bounds.Include(500030, 5000010);
  EXPECT_TRUE(bounds.Contains(500030, 5000010));
  bounds.Include(500010, 5000040);
  bounds.Include(500020, 5000020);
  EXPECT_FALSE(bounds.Empty());
  EXPECT_EQ(bounds.min_x, 500010);
  EXPECT_EQ(bounds.min_y, 5000010);
  EXPECT_EQ(bounds.max_x, 500030);
  EXPECT_EQ(bounds.max_y, 5000040);
}

TEST(Bounds, OverlapWhereTheyHaveAnAreaInCommon) {
  const Bounds bounds{0, 0, 10, 10};
  EXPECT_TRUE(bounds.Overlaps({9, 9, 20, 20}));
  EXPECT_TRUE(bounds.Overlaps({4, -5, 6, 15}));
  EXPECT_TRUE(bounds.Overlaps(bounds));
  EXPECT_FALSE(bounds.Overlaps({10, 0, 20, 10}));
  EXPECT_FALSE(bounds.Overlaps({0, 11, 10, 20}));
  EXPECT_FALSE(bounds.Overlaps(Bounds::OfNothing()));
}

}  // namespace
}  // namespace orient
