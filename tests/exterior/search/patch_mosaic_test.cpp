#include "exterior/search/patch_mosaic.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace orient::exterior {
namespace {

// Grey values that rise eastwards and northwards, known everywhere.
double GreyAt(double x_m, double y_m) { return 100 + 0.3 * (x_m - 1000) + 0.1 * (y_m - 2000); }

patchdb::Patch PatchAt(double x_m, double y_m, double gsd_m, double height_m = 50) {
  patchdb::Patch patch;
  patch.ground_m = {x_m, y_m, height_m};
  patch.gsd_m = gsd_m;
  patch.chip = Image(21, 21);
  for (int row = 0; row < 21; ++row)
    for (int col = 0; col < 21; ++col)
      patch.chip.At(col, row) = static_cast<float>(
          GreyAt(x_m + (col + 0.5 - 10.5) * gsd_m, y_m - (row + 0.5 - 10.5) * gsd_m));
  return patch;
}

// The ground at an offset in an image of kappa, y of the image downwards.
Eigen::Matrix2d Turned(double kappa, double pixel_m) {
  return pixel_m * Eigen::Rotation2Dd(kappa).toRotationMatrix() *
         Eigen::Vector2d(1, -1).asDiagonal();
}

void ExpectDrawnAsItIs(const PatchMosaic& mosaic, const Eigen::Matrix2d& ground_from_image) {
  const Eigen::Vector2d centre(1003, 1998);
  const Image image = mosaic.Draw(centre, ground_from_image, 5);
  for (int row = 0; row < 5; ++row)
    for (int col = 0; col < 5; ++col) {
      const Eigen::Vector2d ground =
          centre + ground_from_image * Eigen::Vector2d(col - 2.0, row - 2.0);
      EXPECT_NEAR(image.At(col, row), GreyAt(ground.x(), ground.y()), 0.35) << col << " " << row;
    }
}

TEST(PatchMosaic, ShowsTheGroundAtEveryKappa) {
  const auto mosaic = PatchMosaic::Of({PatchAt(1000, 2000, 1), PatchAt(1015, 2004, 1)}, 2);
  ASSERT_TRUE(mosaic);
  for (const double kappa : {0.0, 0.7, std::numbers::pi / 2, -2.5})
    ExpectDrawnAsItIs(*mosaic, Turned(kappa, 2));
}

TEST(PatchMosaic, HasNoHolesUnderChipsCoarserThanItsCells) {
  const auto mosaic = PatchMosaic::Of({PatchAt(1000, 2000, 2)}, 0.9);
  ASSERT_TRUE(mosaic);
  for (const float value : mosaic->Draw({1000, 2000}, Turned(0, 0.9), 21).values)
    EXPECT_TRUE(std::isfinite(value));
}

TEST(PatchMosaic, HasGapsBetweenPatches) {
  const auto mosaic = PatchMosaic::Of({PatchAt(1000, 2000, 1), PatchAt(1100, 2000, 1)}, 2);
  ASSERT_TRUE(mosaic);
  for (const float value : mosaic->Draw({1050, 2000}, Turned(0, 2), 5).values)
    EXPECT_TRUE(std::isnan(value));
}

TEST(PatchMosaic, KnowsTheHeightsAroundAPoint) {
  const auto mosaic = PatchMosaic::Of(
      {PatchAt(1000, 2000, 1, 10), PatchAt(1010, 2000, 1, 30), PatchAt(1100, 2000, 1, 500)}, 2);
  ASSERT_TRUE(mosaic);
  EXPECT_DOUBLE_EQ(mosaic->HeightAround({1005, 2000}, 20), 20);
  EXPECT_TRUE(std::isnan(mosaic->HeightAround({1050, 2000}, 20)));
}

TEST(PatchMosaic, IsNotMadeOfPatchesTooFarApart) {
  EXPECT_FALSE(PatchMosaic::Of({PatchAt(1000, 2000, 1), PatchAt(9e6, 2000, 1)}, 1, 1e6));
  EXPECT_FALSE(PatchMosaic::Of({}, 1));
}

}  // namespace
}  // namespace orient::exterior
