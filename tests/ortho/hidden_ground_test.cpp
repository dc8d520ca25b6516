#include "ortho/hidden_ground.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "tests/support/generators.h"
#include "tests/support/hilly_view.h"

namespace orient::ortho {
namespace {

using Eigen::Vector3d;

const Vector3d kCentre(5000, 3000, 1300);

bool HidesAt(const HiddenGround& hidden, const GroundSurface& surface, double x, double y) {
  return hidden.Hides({x, y, surface.HeightAt(x, y).value()});
}

TEST(HiddenGround, GentleHillsHideNothing) {
  const GroundSurface hills = Hills();
  const HiddenGround hidden(hills, kCentre);
  EXPECT_FALSE(hidden.MayHide({4300, 2300, 5700, 3700}));
  EXPECT_FALSE(HidesAt(hidden, hills, 4400, 2400));
}

// A box 40 m high, its eastern edge 500 m east of a camera 1000 m above the ground: what lies
// behind it is hidden for 40 * 500 / 960 = 20.8 m.
TEST(HiddenGround, ABoxHidesWhatLiesBehindItAsFarAsItsShadowReaches) {
  constexpr int kNodes = 801;
  Eigen::MatrixXf heights = Eigen::MatrixXf::Zero(kNodes, kNodes);
  heights.block(390, 900 - 450, 20, 50).setConstant(40);  // up to column 499
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, kNodes, 1);
  const double edge = 499.5, row = kNodes - 400;  // of the roof; the wall is a cell thick
  const HiddenGround hidden(surface, {edge - 500, row, 1000});
  EXPECT_TRUE(hidden.MayHide({490, row - 20, 530, row + 20}));
  EXPECT_FALSE(HidesAt(hidden, surface, edge - 5, row)) << "the roof";
  EXPECT_TRUE(HidesAt(hidden, surface, edge + 0.5, row)) << "the wall turned away";
  EXPECT_TRUE(HidesAt(hidden, surface, edge + 20, row));
  EXPECT_FALSE(HidesAt(hidden, surface, edge + 22, row));
  EXPECT_FALSE(HidesAt(hidden, surface, 440, row)) << "before the box";
}

TEST(HiddenGround, WhereNothingMayBeHiddenNothingIs) {
  EXPECT_TRUE(rc::check("the quick answer is never wrong", [] {
    constexpr int kNodes = 120;
    const double roughness = *InRange(0, 12);
    Eigen::MatrixXf heights(kNodes, kNodes);
    std::uint32_t state = static_cast<std::uint32_t>(*InRange(1, 1e6));
    for (float& height : heights.reshaped())
      height =
          static_cast<float>(roughness * ((state = state * 1664525u + 1013904223u) >> 24) / 256);
    const GroundSurface surface = GroundSurface::FromGrid(heights, 0, kNodes * 2, 2);
    const HiddenGround hidden(surface, {*InRange(0, 240), *InRange(0, 240), *InRange(60, 300)});
    const double x = *InRange(5, 200), y = *InRange(5, 200);
    if (hidden.MayHide({x, y, x + 30, y + 30})) return;
    for (int i = 0; i < 40; ++i) {
      const double at_x = x + (i * 7 % 30), at_y = y + (i * 11 % 30);
      RC_ASSERT(!HidesAt(hidden, surface, at_x, at_y));
    }
  }));
}

TEST(HiddenGround, ACameraBelowTheHighestPlaceMayBeHiddenFrom) {
  const GroundSurface hills = Hills(true);
  EXPECT_TRUE(HiddenGround(hills, {5000, 3000, 200}).MayHide({4300, 2300, 4400, 2400}));
}

}  // namespace
}  // namespace orient::ortho
