#include "exterior/attitude_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "core/geometry/rotation.h"
#include "core/imaging/raster.h"
#include "tests/support/shared_data.h"
#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr int kSide = 260;
constexpr double kGsd_m = 2, kParcel_m = 60;
constexpr int kChip = 51;

// Mountains: a third of the flying height.
double HeightAt(double x, double y) {
  return 100 * std::sin(x / 130) * std::cos(y / 170) + 0.1 * x;
}

// A photo of mountains of which half has changed: dark has become bright.
class AttitudeSearch : public testing::Test {
 protected:
  AttitudeSearch() {
    Camera& camera = view_.camera;
    camera.kind = CameraKind::kDigital;
    camera.principal_distance_mm = 60;
    camera.frame_mm = {60, 60};
    camera.image_px = Eigen::Vector2i(kSide, kSide);
    view_.photo_from_pixel = DigitalPhotoFromPixel(camera);
    view_.pose = {{10, -20, kGsd_m * kSide}, {0.12, -0.15, 2.3}};
    std::vector<unsigned char> grey;
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col) grey.push_back(GreyAt({col + 0.5, row + 0.5}));
    WritePng(path_, kSide, kSide, 1, grey);
    raster_.emplace(Raster::Open(path_));
    image_.emplace(*raster_, false);
    photo_.camera = camera;
    photo_.positions.push_back({view_.photo_from_pixel, std::nullopt});
  }
  ~AttitudeSearch() override { std::filesystem::remove(path_); }

  unsigned char GreyAt(const Eigen::Vector2d& pixel) const {
    const Ray ray = *GroundRayFromPhoto(view_.camera, view_.pose, view_.PhotoFromPixel(pixel));
    Eigen::Vector3d ground = ray.origin_m;
    for (int i = 0; i < 30; ++i)
      ground = ray.origin_m +
               ray.direction *
                   ((HeightAt(ground.x(), ground.y()) - ray.origin_m.z()) / ray.direction.z());
    const double then = texture_.At(ground.head<2>() / kGsd_m);
    const auto parcel =
        static_cast<int>(std::floor(ground.x() / kParcel_m) + std::floor(ground.y() / kParcel_m));
    return static_cast<unsigned char>(std::clamp(parcel % 2 == 0 ? then : 256 - then, 0.0, 255.0));
  }

  static std::vector<Patch> PatchesOf(const Texture& texture) {
    std::vector<Patch> patches;
    for (int i = -4; i <= 4; ++i)
      for (int j = -4; j <= 4; ++j) {
        Patch patch;
        patch.ground_m = {95.0 * i, 95.0 * j, HeightAt(95.0 * i, 95.0 * j)};
        patch.gsd_m = kGsd_m;
        patch.chip = Image(kChip, kChip);
        for (int row = 0; row < kChip; ++row)
          for (int col = 0; col < kChip; ++col)
            patch.chip.At(col, row) = static_cast<float>(
                texture.At(patch.ground_m.head<2>() / kGsd_m +
                           Eigen::Vector2d(col + 0.5 - kChip / 2.0, kChip / 2.0 - row - 0.5)));
        patch.heights = {15, 10, {}};
        for (int row = 0; row < 15; ++row)
          for (int col = 0; col < 15; ++col)
            patch.heights.heights_m.push_back(static_cast<float>(HeightAt(
                patch.ground_m.x() + 10 * (col - 7), patch.ground_m.y() - 10 * (row - 7))));
        patches.push_back(patch);
      }
    return patches;
  }

  // A position off by a few per cent of the flying height, no tilt, and any kappa.
  std::optional<PoseTrack> Search(const std::vector<Patch>& patches, double kappa) {
    const Eigen::Vector3d off(20, -15, 25);
    photo_.prior.pose = {view_.pose.position_m + off, {0, 0, kappa}};
    Vector6d sigma;
    sigma << 25, 25, 25, 0.17, 0.17, std::numbers::pi;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
    return SearchAttitudes({photo_, *image_, patches, options_}, 100);
  }

  double WorstError(const Pose& pose) const {
    PhotoView found = view_;
    found.pose = pose;
    double worst = 0;
    for (const Patch& patch : PatchesOf(texture_)) {
      const auto truth = view_.PixelFromGround(patch.ground_m);
      if (!truth || !view_.camera.InFrame(view_.PhotoFromPixel(*truth))) continue;
      worst = std::max(worst, (*found.PixelFromGround(patch.ground_m) - *truth).norm());
    }
    return worst;
  }

  const Texture texture_{5, 6};
  PhotoView view_;
  const std::string path_ =
      testing::TempDir() + "/orient_attitude_" + std::to_string(TestSeed()) + ".png";
  std::optional<Raster> raster_;
  std::optional<PhotoImage> image_;
  PhotoToOrient photo_;
  OrientPhotoOptions options_;
};

TEST_F(AttitudeSearch, FindsAnyKappaAndTiltInMountainsOfWhichHalfIsInverted) {
  const auto patches = PatchesOf(texture_);
  const auto track = Search(patches, view_.pose.opk_rad.z() + 2);
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 8);
}

TEST_F(AttitudeSearch, IsNotConvincedByPatchesOfAnotherPlace) {
  const auto track = Search(PatchesOf(Texture(6, 6)), 0);
  ASSERT_TRUE(track);
  EXPECT_GT(track->log10_false_alarms, -3);
}

TEST(IsPositionKnown, ToAFewPerCentOfTheFlyingHeight) {
  PosePrior prior{{{0, 0, 2500}, {0, 0, 0}}, Matrix6d::Identity()};
  const auto with = [&](double sigma_m) {
    prior.covariance.topLeftCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    return IsPositionKnown(prior, 100);
  };
  EXPECT_TRUE(with(100));
  EXPECT_FALSE(with(300));
  EXPECT_FALSE(IsPositionKnown(prior, 3000));
}

}  // namespace
}  // namespace orient
