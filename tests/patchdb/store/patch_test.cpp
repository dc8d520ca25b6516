#include "patchdb/store/patch.h"

#include <gtest/gtest.h>

namespace orient::patchdb {
namespace {

constexpr double kExact = 1e-6;  // float heights of a few hundred metres

HeightGrid Plane() {
  // Height 100 + 2 east + 3 north.
  HeightGrid grid{5, 10, std::vector<float>(25)};
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      grid.heights_m[static_cast<std::size_t>(5 * i + j)] =
          static_cast<float>(100 + 2 * (j - 2) * 10 + 3 * (2 - i) * 10);
  return grid;
}

TEST(HeightGrid, RowZeroLiesInTheNorthAndColumnZeroInTheWest) {
  const HeightGrid grid = Plane();
  EXPECT_NEAR(grid.At(0, 0), 100, kExact);
  EXPECT_NEAR(grid.At(20, 20), 200, kExact);
  EXPECT_NEAR(grid.At(-20, 20), 120, kExact);
  EXPECT_NEAR(grid.At(-20, -20), 0, kExact);
}

TEST(HeightGrid, IsBilinearBetweenNodes) {
  EXPECT_NEAR(Plane().At(3.7, -12.4), 100 + 2 * 3.7 - 3 * 12.4, kExact * 100);
}

TEST(HeightGrid, HasNoHeightOutsideNorWithoutNodes) {
  EXPECT_TRUE(std::isnan(Plane().At(20.01, 0)));
  EXPECT_TRUE(std::isnan(Plane().At(0, -20.01)));
  EXPECT_TRUE(std::isnan(HeightGrid().At(0, 0)));
}

TEST(HeightGrid, UnknownNodeIsUnknownGround) {
  HeightGrid grid = Plane();
  grid.heights_m[12] = kNoData;
  EXPECT_TRUE(std::isnan(grid.At(1, 1)));
  EXPECT_FALSE(std::isnan(grid.At(15, 15)));
}

}  // namespace
}  // namespace orient::patchdb
