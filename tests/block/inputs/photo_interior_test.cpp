#include "block/inputs/photo_interior.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/error.h"
#include "core/raster/raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

constexpr int kSide = 40;
constexpr double kPixel_mm = 6;  // of a scan that is as wide as the film

// Four like marks in the corners: the film may lie in any of eight ways.
class OpenInterior : public testing::Test {
 protected:
  OpenInterior() {
    WritePng(folder_ / "p.png", kSide, kSide, 1, std::vector<unsigned char>(kSide * kSide, 100));
    interior_.photo = "p";
    interior_.status = Status::kOk;
    interior_.width = interior_.height = kSide;
    const double half = 0.5 * kSide * kPixel_mm;
    const Eigen::Matrix2d mm_from_px = Eigen::Vector2d(kPixel_mm, -kPixel_mm).asDiagonal();
    interior_.photo_from_pixel = Affine2d{mm_from_px, {-half, half}};
    interior_.possible_orientations = {ScanOrientation::kR0,   ScanOrientation::kR90,
                                       ScanOrientation::kR180, ScanOrientation::kR270,
                                       ScanOrientation::kM0,   ScanOrientation::kM90,
                                       ScanOrientation::kM180, ScanOrientation::kM270};
    for (const Fiducial& fiducial : camera_.fiducials) {
      MarkResult mark;
      mark.id = fiducial.id;
      mark.state = MarkState::kUsed;
      mark.pixel = interior_.photo_from_pixel->Inverse() * fiducial.position_mm;
      mark.sigma_px = Eigen::Vector2d(0.02, 0.02);
      interior_.marks.push_back(mark);
    }
  }

  PhotoInterior Read(const std::optional<ScanOrientation>& orientation) {
    WriteInteriorResult(folder_.Path(), interior_);
    return PhotoInteriorOf(Raster::Open(folder_ / "p.png"), camera_, folder_.Path(),
                           [&] { return orientation; });
  }

  const TemporaryFolder folder_;
  const CameraFile camera_ = RingCamera();
  InteriorResult interior_;
};

TEST_F(OpenInterior, IsReadInTheOrientationThatExteriorOrientationFound) {
  const Affine2d named = Read(ScanOrientation::kR0).photo_from_pixel;
  const Affine2d turned = Read(ScanOrientation::kR90).photo_from_pixel;
  EXPECT_LT((named.A - interior_.photo_from_pixel->A).norm(), 1e-9);
  EXPECT_EQ(NearestScanOrientation(turned), ScanOrientation::kR90);
  // The marks are where the film has marks, whichever way it lies.
  for (const MarkResult& mark : interior_.marks) {
    const Eigen::Vector2d at = turned * *mark.pixel;
    EXPECT_NEAR(at.cwiseAbs().x(), 106, 1e-6);
    EXPECT_NEAR(at.cwiseAbs().y(), 106, 1e-6);
  }
}

TEST_F(OpenInterior, WithoutOneItIsRefused) {
  ExpectError<InputError>([&] { Read(std::nullopt); },
                          {"p.interior.json", "scan orientation open", "--orientation"});
}

TEST_F(OpenInterior, OneThatTheMarksExcludeIsRefused) {
  interior_.possible_orientations = {ScanOrientation::kR0, ScanOrientation::kR180};
  ExpectError<InputError>([&] { Read(ScanOrientation::kR90); }, {"excludes", "r90"});
}

TEST_F(OpenInterior, KnownOrientationsNeedNoWord) {
  interior_.possible_orientations = {ScanOrientation::kR0};
  EXPECT_LT((Read(std::nullopt).photo_from_pixel.A - interior_.photo_from_pixel->A).norm(), 1e-12);
}

TEST_F(OpenInterior, ScansOfAnotherSizeAreNotTheOriented) {
  interior_.width = kSide + 1;
  ExpectError<InputError>([&] { Read(ScanOrientation::kR0); }, {"41 x 40 px", "again"});
}

}  // namespace
}  // namespace orient::block
