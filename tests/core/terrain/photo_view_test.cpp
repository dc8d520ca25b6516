#include "core/terrain/photo_view.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "core/terrain/ground_surface.h"
#include "tests/support/generators.h"

namespace orient {
namespace {

PhotoView View() {
  PhotoView view;
  view.camera.principal_distance_mm = 150;
  view.camera.frame_mm = {200, 100};
  view.camera.lens = BrownDistortion{{1e-7, 0, 0}, {0, 0}};
  view.photo_from_pixel.A << 0, -0.025, -0.0251, 0;  // r90
  view.photo_from_pixel.t = {115, 114};
  view.pose = {{5000, 3000, 1800}, {0.03, -0.02, 2.0}};
  return view;
}

TEST(PhotoView, PixelGroundPixel) {
  Eigen::MatrixXf heights(80, 80);
  for (int r = 0; r < 80; ++r)
    for (int c = 0; c < 80; ++c) heights(r, c) = static_cast<float>(100 + (r * 7 + c * 13) % 40);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 3000, 5000, 50);
  const PhotoView view = View();
  EXPECT_TRUE(rc::check("pixel -> ground -> pixel", [&] {
    const Eigen::Vector2d pixel(*InRange(2000, 6000), *InRange(2000, 7000));
    const auto ground = view.GroundFromPixel(pixel, surface);
    RC_ASSERT(ground.has_value());
    RC_ASSERT(std::abs(surface.HeightAt(ground->x(), ground->y()).value() - ground->z()) < 1e-4);
    RC_ASSERT((view.PixelFromGround(*ground).value() - pixel).norm() < 1e-6);
  }));
}

TEST(PhotoView, AFilmCorrectionCountsBothWays) {
  const GroundSurface surface =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(80, 80, 120), 3000, 5000, 50);
  PhotoView view = View();
  const Eigen::Vector2d pixel(4100, 4300);
  const Eigen::Vector3d flat = view.GroundFromPixel(pixel, surface).value();
  FilmCorrection grid;
  grid.origin_px = {0, 0};
  grid.step_px = {9000, 9000};
  grid.columns = grid.rows = 2;
  grid.correction_mm = {{0.05, 0}, {0.03, 0.01}, {0.04, -0.02}, {0.05, 0.02}};
  view.film_correction = std::make_shared<const FilmCorrection>(grid);
  const Eigen::Vector3d bent = view.GroundFromPixel(pixel, surface).value();
  // 0.04 mm of film at a scale of 1 : 11200 are half a metre.
  EXPECT_NEAR((bent - flat).norm(), 0.45, 0.1);
  EXPECT_LT((view.PixelFromGround(bent).value() - pixel).norm(), 1e-6);
  EXPECT_GT((view.PixelFromGround(flat).value() - pixel).norm(), 1.0);
}

TEST(PhotoView, NothingBehindTheCameraAndNothingBesideTheDem) {
  const PhotoView view = View();
  EXPECT_FALSE(view.PixelFromGround({5000, 3000, 2000}));
  const GroundSurface far =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(3, 3, 100.f), 90000, 90000, 50);
  EXPECT_FALSE(view.GroundFromPixel({4500, 4500}, far));
}

TEST(PhotoView, PixelSizeIsTheMeanOfBothAxes) { EXPECT_NEAR(View().PixelSize(), 0.02505, 1e-6); }

TEST(FootprintBounds, OfAVerticalPhotoIsTheFrameAtTheLowestGround) {
  Camera camera;
  camera.principal_distance_mm = 150;
  camera.frame_mm = {200, 100};
  const Pose pose = {{1000, 2000, 1600}, {0, 0, 0}};
  const auto bounds = FootprintBounds(camera, pose, 100, 400);
  ASSERT_TRUE(bounds);
  EXPECT_NEAR(bounds->min_x, 0, 1e-9);  // 1500 m below: 100 mm is 1000 m
  EXPECT_NEAR(bounds->max_x, 2000, 1e-9);
  EXPECT_NEAR(bounds->min_y, 1500, 1e-9);
  EXPECT_NEAR(bounds->max_y, 2500, 1e-9);
}

TEST(FootprintBounds, HoldsEveryPointOfTheFrame) {
  const PhotoView view = View();
  const auto bounds = FootprintBounds(view.camera, view.pose, 50, 600);
  ASSERT_TRUE(bounds);
  EXPECT_TRUE(rc::check("ground points of the frame", [&] {
    const Eigen::Vector2d photo(*InRange(-100, 100), *InRange(-50, 50));
    const auto ray = GroundRayFromPhoto(view.camera, view.pose, photo);
    const double height = *InRange(50, 600);
    const double distance = (height - ray->origin_m.z()) / ray->direction.z();
    const Eigen::Vector3d ground = ray->origin_m + distance * ray->direction;
    RC_ASSERT(bounds->Contains(ground.x(), ground.y()));
  }));
}

TEST(FootprintBounds, EmptyAboveTheHorizonAndUnderTheGround) {
  PhotoView view = View();
  EXPECT_FALSE(FootprintBounds(view.camera, view.pose, 2000, 2500));
  view.pose.opk_rad[0] = 1.3;
  EXPECT_FALSE(FootprintBounds(view.camera, view.pose, 50, 600));
}

}  // namespace
}  // namespace orient
