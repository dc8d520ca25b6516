// Marks given as pictures cut from a scan: what surrounds the mark in them is one photo's, and says
// nothing of how another film lies.
#include <gtest/gtest.h>

#include <algorithm>

#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kPixelMm = 0.1;
constexpr int kHalf = 26;  // of a picture, px: the mark and as much of the photo around it

FilmFrame FrameOf(const CameraFile& camera, ScanOrientation orientation, unsigned seed) {
  FilmFrameSpec spec;
  spec.camera = camera;
  spec.orientation = orientation;
  spec.dark_corners = false;  // the marks lie in the picture
  spec.seed = seed;
  spec.noise = 2;
  return RenderFilmFrame(spec);
}

Image PictureAround(const FilmFrame& frame, size_t mark) {
  const Vector2d at = frame.mark_pixels[mark].array().floor();
  Image picture(2 * kHalf + 1, 2 * kHalf + 1);
  for (int row = 0; row < picture.height; ++row)
    for (int col = 0; col < picture.width; ++col)
      picture.At(col, row) = frame.scan.At(static_cast<int>(at.x()) + col - kHalf,
                                           static_cast<int>(at.y()) + row - kHalf);
  return picture;
}

class PictureMarks : public testing::Test {
 protected:
  // The camera with pictures from a film that lies upright: the first mark's for all, or each its
  // own.
  void CutPictures(bool own_for_each) {
    const FilmFrame frame = FrameOf(drawn_, ScanOrientation::kR0, 41);
    camera_ = drawn_;
    camera_.marks.clear();
    for (size_t i = 0; i < camera_.fiducials.size(); ++i) {
      const size_t cut = own_for_each ? i : 0;
      const std::string name = "cut " + std::to_string(cut);
      camera_.fiducials[i].mark = name;
      if (pictures_.contains(name)) continue;
      const Vector2d at = frame.mark_pixels[cut];
      MarkDrawing drawing;
      drawing.image =
          MarkImage{name, kPixelMm, at - Vector2d(at.array().floor()) + Vector2d::Constant(kHalf)};
      camera_.marks[name] = drawing;
      pictures_[name] = PictureAround(frame, cut);
    }
  }

  // The film of another photo, lying so: right in one of the ways left open, and all of them open.
  void ExpectOpen(ScanOrientation orientation, unsigned seed, Status at_least) {
    SCOPED_TRACE(std::string(Name(orientation)));
    const FilmFrame frame = FrameOf(drawn_, orientation, seed);
    WriteScan(folder_ / "scan.png", frame.scan);
    InteriorOptions options;
    options.pixel_size_um = 1e3 * kPixelMm;
    const MarkShapes shapes = ShapesOf(camera_, pictures_);
    const InteriorResult result =
        OrientInterior(Raster::Open(folder_ / "scan.png"), camera_, shapes, options);
    EXPECT_LE(result.status, at_least) << testing::PrintToString(Sentences(result.findings));
    if (result.status != Status::kOk) return;
    EXPECT_FALSE(result.orientation);
    EXPECT_EQ(result.possible_orientations.size(), kAllScanOrientations.size());
    const auto turned = InOrientation(result, camera_, shapes, orientation);
    ASSERT_TRUE(turned);
    const Affine2d pixel_from_photo = turned->photo_from_pixel->Inverse();
    for (size_t i = 0; i < camera_.fiducials.size(); ++i)
      EXPECT_LT((pixel_from_photo * camera_.fiducials[i].position_mm - frame.mark_pixels[i]).norm(),
                1.0);
  }

  TemporaryFolder folder_;
  CameraFile drawn_ = RingCamera(24, 60), camera_;
  std::map<std::string, Image> pictures_;
};
class SlowPictureMarks : public PictureMarks {};

TEST_F(PictureMarks, OnePictureForEqualMarksLeavesTheOrientationOpen) {
  CutPictures(false);
  ExpectOpen(ScanOrientation::kR0, 41, Status::kOk);  // its own photo
  ExpectOpen(ScanOrientation::kR0, 52, Status::kWeak);
  ExpectOpen(ScanOrientation::kM90, 53, Status::kFailed);
}

TEST_F(PictureMarks, ThePhotoAroundTheMarksDecidesNothing) {
  CutPictures(true);
  ExpectOpen(ScanOrientation::kR0, 41, Status::kOk);  // their own photo
  ExpectOpen(ScanOrientation::kM90, 61, Status::kFailed);
}

TEST_F(SlowPictureMarks, ThePhotoAroundTheMarksDecidesNothingHoweverTheFilmLies) {
  CutPictures(true);
  for (unsigned seed = 100; seed < 124; ++seed)
    ExpectOpen(kAllScanOrientations[seed % 8], seed, Status::kFailed);
}

}  // namespace
}  // namespace orient::interior
