#include "patchdb/harvest/control_points.h"

#include <gtest/gtest.h>

#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "tests/patchdb/harvest/synthetic_ground.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

class ControlPointTest : public testing::Test {
 protected:
  void SetUp() override {
    WriteGreyPng(folder_ / "photo.png", RenderPhoto(view_, surface_, texture_));
    raster_ = std::make_unique<Raster>(Raster::Open(folder_ / "photo.png"));
    source_ = MakePhotoSource(view_, std::nullopt, 0.5, surface_);
    further_ = {raster_.get(), source_.get(), nullptr, 3};
    point_.id = "A";
    point_.ground_m = {500480, 5000530, *surface_.HeightAt(500480, 5000530)};
    point_.sigma_m = {0.02, 0.03, 0.05};
  }

  std::variant<Patch, ControlRefusal> Make(const Eigen::Vector2d& off_px) const {
    const Eigen::Vector2d pixel = *source_->PixelFromGround(point_.ground_m) + off_px;
    return MakeControlPatch(point_, {{&further_, pixel}}, surface_, 61);
  }

  TemporaryFolder folder_;
  SyntheticTexture texture_{TestSeed()};
  GroundSurface surface_ = SyntheticSurface();
  PhotoView view_ = SyntheticView(0.4);
  std::unique_ptr<Raster> raster_;
  std::unique_ptr<SourceView> source_;
  FurtherSource further_;
  ControlPoint point_;
};

TEST_F(ControlPointTest, KeepsTheSurveyedPositionAndItsSigmas) {
  const auto made = Make({0, 0});
  ASSERT_TRUE(std::holds_alternative<Patch>(made));
  const Patch& patch = std::get<Patch>(made);
  EXPECT_EQ(patch.ground_m, point_.ground_m);
  EXPECT_NEAR(std::sqrt(patch.covariance_m2(1, 1)), 0.03, 1e-12);
  EXPECT_NEAR(patch.heights.At(0, 0), point_.ground_m.z(), 1e-3);
  EXPECT_FALSE(patch.height_effect);
  EXPECT_TRUE(patch.quality);
}

TEST_F(ControlPointTest, TheMeasuredPixelIsTheChipsMiddle) {
  const Eigen::Vector2d off(0.8, -0.6);
  const auto made = Make(off);
  ASSERT_TRUE(std::holds_alternative<Patch>(made));
  const Patch& patch = std::get<Patch>(made);
  const ImageWindow photo = raster_->ReadGrey();
  const Eigen::Vector2d pixel = *source_->PixelFromGround(point_.ground_m) + off;
  EXPECT_NEAR(static_cast<double>(SampleBicubic(patch.chip, {30.5, 30.5})),
              static_cast<double>(SampleBicubic(photo.image, pixel)), 0.6);
}

TEST_F(ControlPointTest, AMeasurementFarFromTheOrientationIsRefused) {
  const auto made = Make({6, 0});
  ASSERT_TRUE(std::holds_alternative<ControlRefusal>(made));
  EXPECT_EQ(std::get<ControlRefusal>(made), ControlRefusal::kContradicted);
}

TEST_F(ControlPointTest, APointAtThePhotosBorderIsRefused) {
  point_.ground_m = *source_->GroundFromPixel({12, 250});
  const auto made = Make({0, 0});
  ASSERT_TRUE(std::holds_alternative<ControlRefusal>(made));
  EXPECT_EQ(std::get<ControlRefusal>(made), ControlRefusal::kNoImage);
}

}  // namespace
}  // namespace orient::patchdb
