#include "core/geometry/camera.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

Camera Digital() {
  Camera camera;
  camera.name = "small DMC";
  camera.kind = CameraKind::kDigital;
  camera.principal_distance_mm = 120;
  camera.frame_mm = {64, 115.2};
  camera.image_px = Eigen::Vector2i(640, 1152);
  return camera;
}

TEST(Camera, DigitalPixelsHaveTheirOriginInTheMiddleAndYUp) {
  const Affine2d photo_from_pixel = DigitalPhotoFromPixel(Digital());
  EXPECT_LT((photo_from_pixel * Eigen::Vector2d(320, 576)).norm(), 1e-12);
  EXPECT_LT((photo_from_pixel * Eigen::Vector2d(0, 0) - Eigen::Vector2d(-32, 57.6)).norm(), 1e-12);
  EXPECT_LT((photo_from_pixel * Eigen::Vector2d(640, 576) - Eigen::Vector2d(32, 0)).norm(), 1e-12);
}

TEST(Camera, FilmHasNoFixedTransform) {
  Camera film = Digital();
  film.kind = CameraKind::kFilm;
  EXPECT_THROW(DigitalPhotoFromPixel(film), std::invalid_argument);
  Camera sizeless = Digital();
  sizeless.image_px.reset();
  EXPECT_THROW(DigitalPhotoFromPixel(sizeless), std::invalid_argument);
}

TEST(Camera, FrameLiesAroundItsOwnCentre) {
  Camera camera;
  camera.frame_mm = {20, 10};
  camera.frame_centre_mm = {100, 0};
  EXPECT_TRUE(camera.InFrame({109, 4}));
  EXPECT_FALSE(camera.InFrame({109, 6}));
  EXPECT_FALSE(camera.InFrame({0, 0}));
  EXPECT_TRUE(camera.InFrame({109, 6}, 1.5));
  EXPECT_FALSE(camera.InFrame({109, 4}, -1.5));
}

}  // namespace
}  // namespace orient
