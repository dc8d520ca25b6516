#include "patchdb/harvest/source_view.h"

#include <gtest/gtest.h>

#include "patchdb/harvest/place.h"
#include "patchdb/harvest/rectify.h"
#include "tests/patchdb/harvest/synthetic_ground.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

constexpr double kTooHigh = 3;  // m, of the DEM

GroundSurface Level(double height_m) {
  return GroundSurface::FromGrid(Eigen::MatrixXf::Constant(100, 100, static_cast<float>(height_m)),
                                 kWest, kNorth, 10);
}

PhotoView Vertical() {
  PhotoView view = SyntheticView(0);
  view.pose.opk_rad.setZero();
  return view;
}

// Where a map that was made of the view with heights that are too high shows what lies at `truth`.
Eigen::Vector3d ShownAt(const Eigen::Vector3d& truth) {
  const PhotoView view = Vertical();
  const auto photo = PhotoFromGround(view.camera, view.pose, truth);
  return *view.GroundFromPixel(view.PixelFromPhoto(*photo), Level(truth.z() + kTooHigh));
}

// Of the made-up ground: its middle is the vertical view's nadir.
class OrthoOfOneFrame : public testing::Test {
 protected:
  OrthoOfOneFrame() {
    Affine2d map_from_pixel;
    map_from_pixel.A << 10, 0, 0, -10;
    map_from_pixel.t << kWest, kNorth;
    WriteOrtho(folder_ / "ortho.png", Image(100, 100, 50), map_from_pixel, "EPSG:32635");
    source_ = MakeOrthoSource(Raster::Open(folder_ / "ortho.png"), Crs::Parse("EPSG:32635", "test"),
                              0.5, surface_);
  }
  TemporaryFolder folder_;
  GroundSurface surface_ = Level(300);
  std::unique_ptr<SourceView> source_;
};

TEST(HeightEffect, OfAPhotoIsHowThePointMovesThatItIsTakenFor) {
  const GroundSurface surface = Level(300);
  const auto source = MakePhotoSource(Vertical(), std::nullopt, 0.5, surface);
  const Eigen::Vector3d truth(500650, 5000420, 300);
  EXPECT_LT(((ShownAt(truth) - truth) / kTooHigh - source->HeightEffect(truth)).norm(), 1e-3);
}

TEST_F(OrthoOfOneFrame, HeightEffectPointsWhereItsContentMoves) {
  for (const Eigen::Vector3d& truth :
       {Eigen::Vector3d(500650, 5000420, 300), Eigen::Vector3d(500400, 5000700, 300)}) {
    const Eigen::Vector2d moved = (ShownAt(truth) - truth).head<2>() / kTooHigh;
    const Eigen::Vector3d effect = source_->HeightEffect(truth);
    // How high the camera was is only guessed.
    EXPECT_GT(effect.head<2>().normalized().dot(moved.normalized()), 0.999);
    EXPECT_NEAR(effect.head<2>().norm() / moved.norm(), 1, 0.3);
    EXPECT_EQ(effect.z(), 0);
  }
}

TEST_F(OrthoOfOneFrame, PatchSaysHowItsPlaceMovesWithTheHeightsOfItsOrthophoto) {
  const Eigen::Vector3d truth(500650, 5000420, 300);
  const Eigen::Vector3d shown(ShownAt(truth).x(), ShownAt(truth).y(), 300);
  const HeightGrid heights = CutHeights(surface_, shown.head<2>(), 30, 1);
  const Sighting sighting{source_.get(), *source_->PixelFromGround(shown),
                          Eigen::Matrix2d::Identity() * 0.01};
  const auto place = EstimatePlace({sighting}, heights, shown, 2.0);
  ASSERT_TRUE(place);
  EXPECT_LT((place->ground_m - shown).norm(), 1e-3);
  EXPECT_LT((place->height_effect - source_->HeightEffect(shown)).norm(), 1e-3);
  // Taken back along it, the patch lies nearly where it should.
  const Eigen::Vector2d mended = (place->ground_m - kTooHigh * place->height_effect).head<2>();
  EXPECT_LT((mended - truth.head<2>()).norm(), 0.3 * (shown - truth).head<2>().norm());
}

}  // namespace
}  // namespace orient::patchdb
