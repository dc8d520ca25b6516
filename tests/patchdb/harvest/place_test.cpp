#include "patchdb/harvest/place.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

#include "patchdb/harvest/rectify.h"
#include "tests/patchdb/harvest/synthetic_ground.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

constexpr double kGsd = 0.11 / 100 * 900;  // of the synthetic view on the level ground

GroundSurface Level() {
  return GroundSurface::FromGrid(Eigen::MatrixXf::Constant(100, 100, 300), kWest, kNorth, 10);
}

PhotoView VerticalView(double east_m = 0) {
  PhotoView view = SyntheticView(0);
  view.pose.opk_rad.setZero();
  view.pose.position_m.x() += east_m;
  return view;
}

Sighting Seen(const SourceView& view, const Eigen::Vector3d& ground, double sigma_px) {
  return {&view, *view.PixelFromGround(ground),
          Eigen::Matrix2d::Identity() * (sigma_px * sigma_px)};
}

TEST(PlaceTest, OfAVerticalViewOnLevelGroundIsTheErrorBudget) {
  const GroundSurface level = Level();
  const auto source = MakePhotoSource(VerticalView(), std::nullopt, 0.5, level);
  // 200 m to the east of the nadir: a height error of 2 m leans by 2 * 200 / 900.
  const Eigen::Vector3d ground(500700, 5000500, 300);
  const HeightGrid heights = CutHeights(level, ground.head<2>(), 30, 1);
  const auto place = EstimatePlace({Seen(*source, ground, 0.1)}, heights, ground, 2.0);
  ASSERT_TRUE(place);
  const double pixel = kGsd * kGsd * (0.25 + 0.01), lean = 2.0 * 200 / 900;
  EXPECT_LT((place->ground_m - ground).norm(), 1e-4);
  EXPECT_NEAR(place->covariance_m2(0, 0), pixel + lean * lean, 1e-3);
  EXPECT_NEAR(place->covariance_m2(1, 1), pixel, 1e-3);
  EXPECT_NEAR(place->covariance_m2(2, 2), 4, 1e-3);
  EXPECT_NEAR(place->covariance_m2(0, 2), -lean * 2, 1e-3);
  EXPECT_NEAR(place->height_effect.x(), -200.0 / 900, 1e-3);
  EXPECT_NEAR(place->height_effect.z(), 1, 1e-3);
  EXPECT_EQ(place->height_test, 0);
}

TEST(PlaceTest, PoseCovarianceCarriesThrough) {
  const GroundSurface level = Level();
  Matrix6d pose = Matrix6d::Zero();
  pose(0, 0) = 9;  // 3 m in X moves every ground point by 3 m
  const auto source = MakePhotoSource(VerticalView(), pose, 0.5, level);
  const Eigen::Vector3d ground(500500, 5000500, 300);
  const HeightGrid heights = CutHeights(level, ground.head<2>(), 30, 1);
  const auto place = EstimatePlace({Seen(*source, ground, 1e-4)}, heights, ground, 1e-3);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->covariance_m2(0, 0), 9, 1e-4);
  EXPECT_NEAR(place->covariance_m2(1, 1), 0, 1e-4);
}

// Its nodes are as far apart as the chip is wide: from the middle a whole step still lies within
// the grid, from anywhere else it would not.
TEST(PlaceTest, ACoarseDemLocatesAPlaceBesideTheMiddleOfItsGrid) {
  const GroundSurface level = Level();
  const auto left = MakePhotoSource(VerticalView(-150), std::nullopt, 0.1, level);
  const auto right = MakePhotoSource(VerticalView(150), std::nullopt, 0.1, level);
  const Eigen::Vector3d truth(500501, 5000499, 300), start(500500, 5000500, 300);
  const HeightGrid heights = CutHeights(level, start.head<2>(), 15, 20);
  ASSERT_LE((heights.size - 1) / 2.0, 1.0);
  const auto place =
      EstimatePlace({Seen(*left, truth, 0.1), Seen(*right, truth, 0.1)}, heights, start, 2.0);
  ASSERT_TRUE(place);
  EXPECT_LT((place->ground_m - truth).norm(), 0.01);
}

TEST(PlaceTest, TwoViewsIntersectAndTheDemHardlyCounts) {
  const GroundSurface level = Level();
  const auto left = MakePhotoSource(VerticalView(-150), std::nullopt, 0.1, level);
  const auto right = MakePhotoSource(VerticalView(150), std::nullopt, 0.1, level);
  const Eigen::Vector3d truth(500500, 5000500, 303);  // the DEM is 3 m too low, its sigma 5 m
  const Eigen::Vector3d start(500501, 5000500, 300);
  const HeightGrid heights = CutHeights(level, start.head<2>(), 30, 1);
  const auto place =
      EstimatePlace({Seen(*left, truth, 0.1), Seen(*right, truth, 0.1)}, heights, start, 5.0);
  ASSERT_TRUE(place);
  EXPECT_NEAR(place->ground_m.z(), 303, 0.05);
  EXPECT_LT(std::sqrt(place->covariance_m2(2, 2)), 0.6);
  EXPECT_LT(place->height_effect.norm(), 0.02);
  EXPECT_NEAR(place->height_test, -3 / 5.0, 0.02);
  EXPECT_LT(place->sighting_test, 1);
}

TEST(PlaceTest, ARoofContradictsTheDem) {
  const GroundSurface level = Level();
  const auto left = MakePhotoSource(VerticalView(-150), std::nullopt, 0.3, level);
  const auto right = MakePhotoSource(VerticalView(150), std::nullopt, 0.3, level);
  const Eigen::Vector3d roof(500500, 5000500, 308), start(500500, 5000500, 300);
  const HeightGrid heights = CutHeights(level, start.head<2>(), 30, 1);
  const auto place =
      EstimatePlace({Seen(*left, roof, 0.1), Seen(*right, roof, 0.1)}, heights, start, 1.0);
  ASSERT_TRUE(place);
  EXPECT_GT(std::abs(place->height_test), 4);
}

TEST(PlaceTest, RaysThatDoNotMeetAreSaid) {
  const GroundSurface level = Level();
  const auto left = MakePhotoSource(VerticalView(-150), std::nullopt, 0.3, level);
  const auto right = MakePhotoSource(VerticalView(150), std::nullopt, 0.3, level);
  const Eigen::Vector3d ground(500500, 5000500, 300);
  const HeightGrid heights = CutHeights(level, ground.head<2>(), 30, 1);
  Sighting wrong = Seen(*right, ground, 0.1);
  wrong.pixel.y() += 3;  // across the base
  const auto place = EstimatePlace({Seen(*left, ground, 0.1), wrong}, heights, ground, 1.0);
  ASSERT_TRUE(place);
  EXPECT_GT(place->sighting_test, 20);
  EXPECT_LT(std::abs(place->height_test), 1);
}

// Errors over their covariance: each of three coordinates of a point counts once on average.
TEST(PlaceTest, CovarianceIsHonest) {
  const GroundSurface surface = SyntheticSurface();
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> within(-150, 150);
  for (const int views : {1, 2, 3}) {
    double sum = 0;
    constexpr int kPoints = 300;
    int points = 0;
    for (int i = 0; i < kPoints; ++i) {
      const double x = 500500 + within(random), y = 5000500 + within(random);
      const double sigma_height = 1.5;
      const Eigen::Vector3d truth(x, y, *surface.HeightAt(x, y) + sigma_height * normal(random));
      std::vector<std::unique_ptr<SourceView>> sources;
      std::vector<Sighting> sightings;
      for (int k = 0; k < views; ++k) {
        sources.push_back(
            MakePhotoSource(VerticalView(120.0 * (k - 1)), std::nullopt, 0.4, surface));
        Sighting sighting = Seen(*sources.back(), truth, 0.2);
        sighting.pixel += std::hypot(0.4, 0.2) * Eigen::Vector2d(normal(random), normal(random));
        sightings.push_back(sighting);
      }
      const auto start = sources[0]->GroundFromPixel(sightings[0].pixel);
      ASSERT_TRUE(start);
      const HeightGrid heights = CutHeights(surface, start->head<2>(), 40, 1);
      const auto place = EstimatePlace(sightings, heights, *start, sigma_height);
      if (!place) continue;
      const Eigen::Vector3d error = place->ground_m - truth;
      sum += error.dot(place->covariance_m2.inverse() * error);
      ++points;
    }
    ASSERT_GT(points, 0.97 * kPoints);
    EXPECT_NEAR(std::sqrt(sum / (3 * points)), 1, 0.12) << views << " views";
  }
}

}  // namespace
}  // namespace orient::patchdb
