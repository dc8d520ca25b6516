// What a patch's chip shows in its middle, and where the patch says that this lies.
#include <gtest/gtest.h>

#include <algorithm>
#include <deque>

#include "core/base/median.h"
#include "core/matching/least_squares_matching.h"
#include "core/raster/png_bands.h"
#include "patchdb/harvest/harvest.h"
#include "patchdb/harvest/source_view.h"
#include "tests/patchdb/harvest/synthetic_ground.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

// Photos of one place from three sides. The middle one is harvested, and its orientation may be
// wrong by metres; the others' are true and known to be so.
class PatchMakingTest : public testing::Test {
 protected:
  static constexpr double kPoseSigma = 3;  // m, of the harvested photo's position

  void SetUp() override {
    surface_ = SyntheticSurface();
    AddFurther(-250, 1);
    AddFurther(250, 2);
    view_ = SyntheticView(0.3);
    const Image grey = RenderPhoto(view_, surface_, texture_);
    std::vector<unsigned char> rgb;
    for (const float value : grey.values)
      rgb.insert(rgb.end(), 3, static_cast<unsigned char>(std::lround(value)));
    WritePng(folder_ / "photo.png", grey.width, grey.height, 3, rgb);
    options_.spacing_px = 90;
    options_.dem_sigma_m = 0.5;
    options_.colour = true;
    for (const Further& other : further_)
      context_.further.push_back({&other.raster, other.view.get(), nullptr, other.number});
  }

  void AddFurther(double east_m, int number) {
    PhotoView view = SyntheticView(0.3);
    view.pose.position_m.x() += east_m;
    const std::string path = folder_ / (std::to_string(number) + ".png");
    WriteGreyPng(path, RenderPhoto(view, surface_, texture_));
    further_.push_back(
        {Raster::Open(path),
         MakePhotoSource(view, Matrix6d(Matrix6d::Identity() * 1e-10), 0.5, surface_), number});
  }

  HarvestResult HarvestWith(const Eigen::Vector3d& pose_error_m) const {
    PhotoView wrong = view_;
    wrong.pose.position_m += pose_error_m;
    Matrix6d covariance = Matrix6d::Identity() * 1e-10;
    covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * (kPoseSigma * kPoseSigma);
    return HarvestPhoto(Raster::Open(folder_ / "photo.png"), wrong, covariance, surface_, options_,
                        {}, context_);
  }

  // How far, in chip pixels, from the chip's middle it shows what truly lies at ground_m.
  double Off(const Patch& patch, const Image& chip) const {
    const int side = chip.width;
    Image truth(side, side);
    for (int row = 0; row < side; ++row)
      for (int col = 0; col < side; ++col)
        truth.At(col, row) =
            texture_.At(patch.ground_m.x() + (col + 0.5 - 0.5 * side) * patch.gsd_m,
                        patch.ground_m.y() - (row + 0.5 - 0.5 * side) * patch.gsd_m);
    LsmOptions options;
    options.geometry = LsmGeometry::kShift;
    options.max_shift_px = 5;
    const Eigen::Vector2d middle = Eigen::Vector2d::Constant(0.5 * side);
    const auto match = MatchLeastSquares(truth, chip, middle, Affine2d(), options);
    return match ? (match->position - middle).norm() : 99;
  }

  struct Further {
    Raster raster;
    std::unique_ptr<SourceView> view;
    int number;
  };
  TemporaryFolder folder_;
  SyntheticTexture texture_{TestSeed()};
  GroundSurface surface_ = SyntheticSurface();
  std::deque<Further> further_;
  PhotoView view_;
  HarvestOptions options_;
  HarvestContext context_;
};

TEST_F(PatchMakingTest, ChipsMiddleShowsWhatLiesAtTheGroundPointThoughItsOwnPhotoIsOff) {
  const HarvestResult harvest = HarvestWith({2, -1.5, 1});
  std::vector<double> off, in_colour;
  for (const Patch& patch : harvest.patches) {
    if (patch.views < 2) continue;
    off.push_back(Off(patch, patch.chip));
    in_colour.push_back(Off(patch, GreyOfBands(patch.colour)));
  }
  ASSERT_GT(off.size(), 10u);
  // About 1 m a pixel: as far off as the photo, if the chip were cut where that has ground_m.
  EXPECT_LT(UpperMedian(off), 0.15);
  EXPECT_LT(UpperMedian(in_colour), 0.15);
  EXPECT_LT(*std::max_element(off.begin(), off.end()), 0.6);
}

}  // namespace
}  // namespace orient::patchdb
