#include "tools/report/figures/photo_accuracy.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/terrain/ground_surface.h"
#include "tests/tools/report/example_block.h"

namespace orient {
namespace {

Camera SomeCamera() {
  Camera camera;
  camera.kind = CameraKind::kDigital;
  camera.principal_distance_mm = 100;
  camera.frame_mm = {50, 50};
  camera.image_px = Eigen::Vector2i(2000, 2000);
  return camera;
}

// What an orthophoto over the same level ground would state.
TEST(PhotoAccuracy, IsWhatAnOrthophotoStates) {
  const ExteriorResult photo = ExampleExterior("4711", Status::kOk);
  const auto stated = AccuracyOnLevelGround(photo, SomeCamera());
  ASSERT_TRUE(stated);
  const GroundSurface level =
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(400, 400, 400), 498000, 5002000, 10);
  const PhotoView view{SomeCamera(), Affine2d{0.025 * Eigen::Matrix2d::Identity(), {-25, -25}},
                       *photo.pose};
  const auto orthophoto = AccuracyOf(view, *photo.covariance, level, 0);
  ASSERT_TRUE(orthophoto);
  constexpr double kSame = 1e-6;
  EXPECT_NEAR(stated->median_m, orthophoto->median_m, kSame);
  EXPECT_NEAR(stated->worst_m, orthophoto->worst_m, kSame);
}

TEST(PhotoAccuracy, IsUnknownWithoutPoseCovarianceOrGround) {
  ExteriorResult photo = ExampleExterior("4711", Status::kOk);
  photo.covariance.reset();
  EXPECT_FALSE(AccuracyOnLevelGround(photo, SomeCamera()));
  photo = ExampleExterior("4711", Status::kOk);
  photo.footprint_m.clear();
  EXPECT_FALSE(AccuracyOnLevelGround(photo, SomeCamera()));
  EXPECT_FALSE(AccuracyOnLevelGround(ExampleExterior("4713", Status::kFailed), SomeCamera()));
}

TEST(PhotoAccuracy, AbsurdNumbersHaveNone) {
  ExteriorResult photo = ExampleExterior("4711", Status::kOk);
  photo.footprint_m[1].x() = 1e300;
  EXPECT_FALSE(AccuracyOnLevelGround(photo, SomeCamera()));
  photo = ExampleExterior("4711", Status::kOk);
  (*photo.covariance)(0, 0) = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(AccuracyOnLevelGround(photo, SomeCamera()));
}

}  // namespace
}  // namespace orient
