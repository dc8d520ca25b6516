#include "core/terrain/view_over_ground.h"

#include <gtest/gtest.h>

#include <limits>

namespace orient {
namespace {

TEST(ViewOverGround, HeightsAreThoseUnderThePhotoNotTheBlocksMean) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(50, 100, 100);
  heights.rightCols(50).setConstant(2100);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 5000, 100);
  Camera camera;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  EXPECT_NEAR(GroundHeightUnder(surface, camera, {{2000, 2500, 3000}, {0, 0, 0}}), 100, 1);
  EXPECT_NEAR(GroundHeightUnder(surface, camera, {{8000, 2500, 4000}, {0, 0, 0}}), 2100, 1);
}

// The left half of the block is low, and so is all that the photo shows; its middle has no heights.
TEST(ViewOverGround, OverAHoleTheHeightIsThatOfTheFrameAround) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(50, 100, 100);
  heights.rightCols(50).setConstant(2100);
  heights.block(15, 10, 20, 20).setConstant(std::numeric_limits<float>::quiet_NaN());
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 5000, 100);
  Camera camera;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  const Pose pose{{2000, 2500, 3000}, {0, 0, 0}};
  EXPECT_NEAR(GroundHeightUnder(surface, camera, pose), 100, 1);
  EXPECT_GT(HeightsInFrame(surface, camera, pose).size(), 50u);
  const Pose low{{2000, 2500, 400}, {0, 0, 0}};
  EXPECT_TRUE(HeightsInFrame(surface, camera, low).empty()) << "it shows nothing but the hole";
  EXPECT_NEAR(GroundHeightUnder(surface, camera, low), surface.MeanHeight(), 1);
}

TEST(ViewOverGround, ShareWithHeightsIsThatOfTheFrameAndNotOfTheGround) {
  const GroundSurface surface =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(51, 101, 100), -50, 5050, 100);
  Camera camera;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  const Pose inside{{5000, 2500, 1630}, {0, 0, 0}}, at_its_end{{0, 2500, 1630}, {0, 0, 0}};
  EXPECT_EQ(ShareWithHeights(surface, camera, inside), 1);
  EXPECT_NEAR(ShareWithHeights(surface, camera, at_its_end), 0.5, 0.02);
  EXPECT_EQ(ShareWithHeights(surface, camera, {{-9000, 2500, 1630}, {0, 0, 0}}), 0);
  const Pose to_the_horizon{{5000, 2500, 200}, {1.57, 0, 0}};
  EXPECT_GT(ShareWithHeights(surface, camera, to_the_horizon), 0.5)
      << "nothing is asked of the sky";
}

TEST(ViewOverGround, AnotherCameraShowsTheSameFromAnotherPlace) {
  PhotoView view;
  view.camera.principal_distance_mm = 153;
  view.camera.frame_mm = {230, 230};
  view.photo_from_pixel.A << 0.025, 0, 0, -0.025;
  view.photo_from_pixel.t << -115, 115;
  view.pose = {{500000, 5000000, 1730}, {0.01, -0.02, 1.2}};
  PhotoView with = view;
  with.camera.principal_distance_mm = 153.3;
  const auto pose = PoseShowingTheSame(view, with, 200);
  ASSERT_TRUE(pose);
  with.pose = *pose;
  EXPECT_NEAR(pose->position_m.z() - view.pose.position_m.z(), 1530 * 0.3 / 153, 0.05);
  const Eigen::Vector3d ground(500300, 5000400, 200);
  EXPECT_LT((*with.PixelFromGround(ground) - *view.PixelFromGround(ground)).norm(), 0.3);
}

}  // namespace
}  // namespace orient
