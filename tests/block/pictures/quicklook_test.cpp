#include "block/pictures/quicklook.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/raster/raster.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr int kSide = 400;                                      // px of a photo
constexpr double kHeight_m = 1000;                              // above flat ground
constexpr double kPixel_mm = 0.1, kPrincipalDistance_mm = 100;  // one metre a pixel

// Texture that repeats nowhere near.
unsigned char GreyOfGround(double x, double y) {
  const double v = std::sin(0.31 * x + 0.002 * y * y) + std::sin(0.23 * y - 0.0031 * x * x) +
                   std::sin(0.11 * (x + y)) + std::sin(0.17 * x - 0.05 * y);
  return static_cast<unsigned char>(std::lround(128 + 28 * v));
}

Camera VerticalCamera() {
  Camera camera;
  camera.kind = CameraKind::kDigital;
  camera.principal_distance_mm = kPrincipalDistance_mm;
  camera.frame_mm = Eigen::Vector2d::Constant(kSide * kPixel_mm);
  camera.image_px = Eigen::Vector2i(kSide, kSide);
  return camera;
}

class QuicklookTest : public testing::Test {
 protected:
  // A photo that truly stands at (x, 0) and is said to stand `error_m` beside it.
  QuicklookPhoto Photo(const std::string& name, double x_m, double error_m = 0) const {
    std::vector<unsigned char> values;
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col)
        values.push_back(GreyOfGround(x_m + col + 0.5 - kSide / 2, kSide / 2 - row - 0.5));
    const std::string path = folder_ / (name + ".png");
    WritePng(path, kSide, kSide, 1, values);
    const Camera camera = VerticalCamera();
    return {name,
            path,
            {camera, DigitalPhotoFromPixel(camera), Pose{{x_m + error_m, 0, kHeight_m}, {0, 0, 0}}},
            false};
  }

  const TemporaryFolder folder_;
  const GroundSurface surface_ =
      GroundSurface::FromGrid(Eigen::MatrixXf::Zero(40, 60), -600, 400, 20);
};

TEST_F(QuicklookTest, OrthophotosOfTruePosesMeet) {
  const auto quicklook =
      WriteQuicklook(folder_.Path(), {Photo("a", -80), Photo("b", 80)}, surface_);
  ASSERT_TRUE(quicklook);
  ASSERT_GE(quicklook->Measured(), 3);
  EXPECT_LT(quicklook->MedianShiftPx().value(), 0.1);
  for (const SeamPlace& seam : quicklook->seams) EXPECT_NEAR(seam.ground_m.x(), 0, 2);
  EXPECT_GT(Raster::Open(folder_ / "quicklook.png").Width(), 1000);
  EXPECT_GT(Raster::Open(folder_ / "seams.png").Width(), 900);
}

// What stands at x is drawn at x + 2 where the photo is said to stand two metres farther east.
TEST_F(QuicklookTest, AWrongPoseShowsAtTheSeamWithItsDirection) {
  const auto quicklook =
      WriteQuicklook(folder_.Path(), {Photo("a", -80), Photo("b", 80, 2)}, surface_);
  ASSERT_TRUE(quicklook);
  ASSERT_GE(quicklook->Measured(), 3);
  EXPECT_NEAR(quicklook->MedianShiftPx().value(), 2, 0.1);
  for (const SeamPlace& seam : quicklook->seams) {
    if (!seam.shift_px) continue;
    EXPECT_NEAR(seam.shift_px->x(), seam.first == "a" ? 2 : -2, 0.1);
    EXPECT_NEAR(seam.shift_px->y(), 0, 0.1);
  }
}

TEST_F(QuicklookTest, PhotosThatDoNotOverlapHaveNoSeamPlaces) {
  const auto quicklook =
      WriteQuicklook(folder_.Path(), {Photo("a", -300), Photo("b", 300)}, surface_);
  ASSERT_TRUE(quicklook);
  EXPECT_TRUE(quicklook->seams.empty());
  EXPECT_FALSE(quicklook->MedianShiftPx());
  EXPECT_FALSE(std::filesystem::exists(folder_ / "seams.png"));
}

TEST_F(QuicklookTest, APhotoThatCannotBeReadIsLeftOut) {
  QuicklookPhoto damaged = Photo("b", 80);
  WriteFileAtomically(damaged.path, "no image");
  const auto quicklook = WriteQuicklook(folder_.Path(), {Photo("a", -80), damaged}, surface_);
  ASSERT_TRUE(quicklook);
  EXPECT_TRUE(quicklook->seams.empty());
  EXPECT_EQ(quicklook->left_out, std::vector<std::string>{"b"});
}

TEST_F(QuicklookTest, WithoutPhotosThereIsNoneAndAnOldOneGoes) {
  WriteFileAtomically(folder_ / "quicklook.png", "old");
  EXPECT_FALSE(WriteQuicklook(folder_.Path(), {}, surface_));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "quicklook.png"));
}

}  // namespace
}  // namespace orient::block
