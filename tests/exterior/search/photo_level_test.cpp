#include "exterior/search/photo_level.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

constexpr int kSide = 15;

// Larger than a tile.
const TexturedPhoto& World() {
  static const TexturedPhoto world(
      620, [](double, double) { return 0.0; }, false);
  return world;
}

Image CutOut(const Eigen::Vector2d& middle_px) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(kSide / 2.0);
  return World().File().Around(middle_px, half, 1).image;
}

TEST(PhotoLevel, FindsWhatWasCutOutWhereverTilesMeet) {
  const PhotoLevel level(World().File(), 1, kSide);
  for (const double x : {7.5, 100.5, 280.5, 281.5, 282.5, 289.5, 555.5, 612.5})
    for (const double y : {7.5, 281.5, 612.5}) {
      const Eigen::Vector2d middle(x, y);
      const auto places = level.Find(CutOut(middle), middle, 1e4, 1, 0.5);
      ASSERT_EQ(places.best.size(), 1u) << middle.transpose();
      EXPECT_LT((places.best.front().pixel - middle).norm(), 0.5) << middle.transpose();
    }
}

TEST(PhotoLevel, SearchesOnlyTheTilesWithinReach) {
  const PhotoLevel level(World().File(), 1, kSide);
  const Eigen::Vector2d far(550, 550), here(100, 100);
  const auto near_only = level.Find(CutOut({550.5, 550.5}), here, 50, 4, 0.9);
  EXPECT_TRUE(near_only.best.empty());
  const auto everywhere = level.Find(CutOut({550.5, 550.5}), here, 1e4, 4, 0.9);
  EXPECT_FALSE(everywhere.best.empty());
  EXPECT_LT(near_only.area_px2, 0.3 * everywhere.area_px2);
}

// What tiles reach beyond the photo was not searched.
TEST(PhotoLevel, AreaIsNotMoreThanThePhotos) {
  const PhotoLevel level(World().File(), 1, kSide);
  const Eigen::Vector2d middle(310.5, 310.5);
  const double area_px2 = level.Find(CutOut(middle), middle, 1e4, 1, 0.5).area_px2;
  EXPECT_LE(area_px2, 620 * 620);
  EXPECT_GT(area_px2, 0.9 * 620 * 620);
}

TEST(PhotoLevel, SaysPlacesInScanPixelsOfAnyLevel) {
  const PhotoLevel level(World().File(), 2, kSide);
  const Eigen::Vector2d middle(301, 201);
  const Image image = World().File().Around(middle, Eigen::Vector2d::Constant(kSide), 2).image;
  const auto places = level.Find(image, middle, 1e4, 1, 0.5);
  ASSERT_EQ(places.best.size(), 1u);
  EXPECT_LT((places.best.front().pixel - middle).norm(), 2.5);
}

}  // namespace
}  // namespace orient::exterior
