#include "tools/simulate/photo_rendering.h"

#include <gtest/gtest.h>

#include "core/geometry/collinearity.h"
#include "core/terrain/ground_surface.h"

namespace orient::simulation {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGroundCell_m = 0.5;
constexpr double kSpotSigma_m = 2.0;

// 400 m x 400 m around (1000, 2000).
constexpr double kWest = 800, kNorth = 2200;
constexpr int kCells = 800;

Terrain FlatTerrain(float height_m) {
  return Terrain(Eigen::MatrixXf::Constant(40, 40, height_m), kWest, kNorth, 10);
}

// Waves of some metres: every cell has another slope.
Terrain HillyTerrain() {
  Eigen::MatrixXf heights(40, 40);
  for (Eigen::Index row = 0; row < 40; ++row)
    for (Eigen::Index col = 0; col < 40; ++col)
      heights(row, col) = 50 + 8 * std::sin(0.4f * static_cast<float>(col)) *
                                   std::cos(0.3f * static_cast<float>(row));
  return Terrain(heights, kWest, kNorth, 10);
}

// Grey ground with one bright round spot, brightest in its middle.
GroundRaster GroundWithSpot(const Vector2d& spot) {
  GroundRaster ground;
  ground.west = kWest;
  ground.north = kNorth;
  ground.cell = kGroundCell_m;
  ground.width = ground.height = kCells;
  for (int row = 0; row < kCells; ++row)
    for (int col = 0; col < kCells; ++col) {
      const Vector2d p(kWest + (col + 0.5) * kGroundCell_m, kNorth - (row + 0.5) * kGroundCell_m);
      const double bright =
          std::exp(-0.5 * (p - spot).squaredNorm() / (kSpotSigma_m * kSpotSigma_m));
      ground.tone.push_back(static_cast<std::uint16_t>(60000 * bright));
    }
  ground.object_cm.assign(ground.tone.size(), 0);
  ground.tiles_across = kCells / ground.tile;
  ground.tallest_cm.assign(static_cast<size_t>(ground.tiles_across * ground.tiles_across), 0);
  return ground;
}

Camera TestCamera() {
  Camera camera;
  camera.principal_distance_mm = 60;
  camera.principal_point_mm = {0.1, -0.2};
  camera.frame_mm = {40, 40};
  camera.lens = BrownDistortion{{-3e-7, 0, 0}, {2e-7, 0}};
  return camera;
}

ScanSetup TestScan(ScanOrientation orientation) {
  ScanSetup setup;
  setup.width = setup.height = 400;
  setup.pixel_size_mm = 0.1;
  setup.orientation = orientation;
  setup.half_frame_mm = 20;
  return setup;
}

Vector2d Centroid(const Image& image) {
  Vector2d sum(0, 0);
  double total = 0;
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col) {
      const double value = image.At(col, row);
      sum += value * Vector2d(col + 0.5, row + 0.5);
      total += value;
    }
  return sum / total;
}

TEST(PhotoRendering, NorthEastAppearsAtUpperRightOfAPlainPositive) {
  Camera camera = TestCamera();
  camera.principal_point_mm = {0, 0};
  camera.lens = std::monostate{};
  const Pose pose{Vector3d(1000, 2000, 700), Vector3d::Zero()};
  const Image image = RenderPhoto(camera, pose, ScanGeometry(TestScan(ScanOrientation::kR0)),
                                  GroundWithSpot({1080, 2050}), FlatTerrain(100), 0);
  // 80 m east and 50 m north at a scale of 1 : 10000 are 8 and 5 mm: 80 and 50 px.
  EXPECT_NEAR(Centroid(image).x(), 280, 0.05);
  EXPECT_NEAR(Centroid(image).y(), 150, 0.05);
}

TEST(PhotoRendering, KappaTurnsTheCameraCounterClockwiseSeenFromAbove) {
  Camera camera = TestCamera();
  camera.principal_point_mm = {0, 0};
  camera.lens = std::monostate{};
  // With kappa = 90 degrees the photo's x axis points north and its y axis west.
  const Pose pose{Vector3d(1000, 2000, 700), Vector3d(0, 0, RadFromDeg(90))};
  const Image image = RenderPhoto(camera, pose, ScanGeometry(TestScan(ScanOrientation::kR0)),
                                  GroundWithSpot({1080, 2050}), FlatTerrain(100), 0);
  EXPECT_NEAR(Centroid(image).x(), 250, 0.05);  // 50 m north: 5 mm along x
  EXPECT_NEAR(Centroid(image).y(), 280, 0.05);  // 80 m east: -8 mm along y
}

TEST(PhotoRendering, HillyGroundAppearsWhereTheCollinearityEquationsSay) {
  constexpr double kWanted_px = 0.03;  // a spot of 2 px on slopes: its own skew is 0.01 px
  const Terrain terrain = HillyTerrain();
  const Pose pose{Vector3d(1010, 1990, 650), Vector3d(0.03, -0.02, 2.0)};
  for (const ScanOrientation orientation : {ScanOrientation::kR0, ScanOrientation::kM90}) {
    ScanSetup setup = TestScan(orientation);
    setup.rotation_rad = 0.01;
    setup.bend = RandomBend(20, 20, 3);
    const ScanGeometry scan(setup);
    for (const Vector2d& spot : {Vector2d(1100, 2070), Vector2d(915, 2062), Vector2d(1003, 1901)}) {
      const Image image = RenderPhoto(TestCamera(), pose, scan, GroundWithSpot(spot), terrain, 0);
      const Vector3d ground(spot.x(), spot.y(), terrain.HeightAt(spot.x(), spot.y()));
      const Vector2d expected =
          scan.PixelFromPhoto(PhotoFromGround(TestCamera(), pose, ground).value());
      EXPECT_LT((Centroid(image) - expected).norm(), kWanted_px) << spot.transpose();
    }
  }
}

TEST(PhotoRendering, RaysMeetTheGroundWhereTheLibrarysSurfaceSays) {
  const Terrain terrain = HillyTerrain();
  const GroundSurface surface =
      GroundSurface::FromGrid(terrain.Heights(), terrain.West(), terrain.North(), terrain.Cell());
  const Vector3d centre(1000, 2000, 600);
  for (const RaySlope& slope : {RaySlope{0, 0}, RaySlope{0.25, 0.1}, RaySlope{-0.2, 0.28}}) {
    const Vector3d direction = Vector3d(slope.east, slope.north, -1).normalized();
    const auto expected = surface.Intersect({centre, direction});
    ASSERT_TRUE(expected.has_value());
    EXPECT_LT((MeetGround(terrain, centre, slope, 40) - *expected).norm(), 0.002);
  }
}

TEST(PhotoRendering, WhatStandsUpLeansOutwards) {
  Camera camera = TestCamera();
  camera.principal_point_mm = {0, 0};
  camera.lens = std::monostate{};
  const Pose pose{Vector3d(1000, 2000, 700), Vector3d::Zero()};
  GroundRaster ground = GroundWithSpot({1080, 2000});
  // A flat roof of 20 m, 20 m wide, under the spot.
  for (int row = 0; row < kCells; ++row)
    for (int col = 0; col < kCells; ++col) {
      const Vector2d p(kWest + (col + 0.5) * kGroundCell_m, kNorth - (row + 0.5) * kGroundCell_m);
      if ((p - Vector2d(1080, 2000)).cwiseAbs().maxCoeff() < 10)
        ground.object_cm[static_cast<size_t>(row * kCells + col)] = 2000;
    }
  std::fill(ground.tallest_cm.begin(), ground.tallest_cm.end(), std::uint16_t{2000});
  const Image image = RenderPhoto(camera, pose, ScanGeometry(TestScan(ScanOrientation::kR0)),
                                  ground, FlatTerrain(100), 0);
  // Seen at 600 - 20 m: 60 * 80 / 580 mm from the centre instead of 8 mm.
  EXPECT_NEAR(Centroid(image).x(), 200 + 600.0 * 80 / 580, 0.15);
  EXPECT_NEAR(Centroid(image).y(), 200, 0.1);
}

TEST(PhotoRendering, NothingIsDrawnOutsideTheFrame) {
  Camera camera = TestCamera();
  camera.frame_mm = {20, 20};
  GroundRaster ground = GroundWithSpot({1000, 2000});
  std::fill(ground.tone.begin(), ground.tone.end(), std::uint16_t{40000});
  const Pose pose{Vector3d(1000, 2000, 700), Vector3d::Zero()};
  const Image image = RenderPhoto(camera, pose, ScanGeometry(TestScan(ScanOrientation::kR0)),
                                  ground, FlatTerrain(100), 0);
  EXPECT_GT(image.At(200, 200), 0.5f);
  EXPECT_GT(image.At(102, 200), 0.4f);
  EXPECT_EQ(image.At(97, 200), 0.0f);
}

}  // namespace
}  // namespace orient::simulation
