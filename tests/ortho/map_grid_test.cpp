#include "ortho/map_grid.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "tests/support/generators.h"

namespace orient::ortho {
namespace {

TEST(MapGrid, HoldsItsBoundsAndLessThanAPixelMore) {
  EXPECT_TRUE(rc::check("around any bounds", [] {
    const double x = *InRange(-1e6, 1e6), y = *InRange(-1e7, 1e7), gsd = *InRange(0.05, 30);
    const Bounds bounds = {x, y, x + *InRange(1, 1e4), y + *InRange(1, 1e4)};
    const Bounds all = MapGrid::Around(bounds, gsd).AllBounds();
    constexpr double kRounding = 1e-6;
    RC_ASSERT(all.min_x <= bounds.min_x + kRounding && all.min_x > bounds.min_x - gsd - kRounding);
    RC_ASSERT(all.min_y <= bounds.min_y + kRounding && all.min_y > bounds.min_y - gsd - kRounding);
    RC_ASSERT(all.max_x >= bounds.max_x - kRounding && all.max_x < bounds.max_x + gsd + kRounding);
    RC_ASSERT(all.max_y >= bounds.max_y - kRounding && all.max_y < bounds.max_y + gsd + kRounding);
  }));
}

TEST(MapGrid, PixelsOfTwoGridsCoincide) {
  const MapGrid a = MapGrid::Around({100.3, 200.7, 180, 290}, 0.3);
  const MapGrid b = MapGrid::Around({131.1, 220.2, 190, 300}, 0.3);
  const Eigen::Vector2d at = b.GroundFromPixel(0, 0);
  EXPECT_LT((a.GroundFromPixel(static_cast<double>(b.west - a.west),
                               static_cast<double>(a.north - b.north)) -
             at)
                .norm(),
            1e-9);
}

}  // namespace
}  // namespace orient::ortho
