#include "interior/constellation/film_frame.h"

#include <gtest/gtest.h>

#include "interior/interior.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

void Paint(int left, int top, const Image& what, Image* bed) {
  for (int row = 0; row < what.height; ++row)
    for (int col = 0; col < what.width; ++col) bed->At(left + col, top + row) = what.At(col, row);
}

ImageWindow Overview(Image image) { return {std::move(image), Vector2d::Zero(), 10}; }

TEST(FindFilmOnBed, FindsAFrameOnWhiteAndOnBlackBeds) {
  for (const float bed : {2.0f, 128.0f, 253.0f}) {
    Image scan(300, 420, bed);
    Paint(150, 60, RenderTexture(90, 80, 3), &scan);
    const auto found = FindFilmOnBed(Overview(scan));
    ASSERT_EQ(found.size(), 1u) << bed;
    EXPECT_LT((found[0].centre_px - Vector2d(1950, 1000)).norm(), 25) << bed;
    EXPECT_LT((found[0].size_px - Vector2d(900, 800)).norm(), 50) << bed;
  }
}

TEST(FindFilmOnBed, ARulerBesideTheFrameDoesNotWidenIt) {
  Image scan(300, 420, 250);
  Paint(100, 60, RenderTexture(120, 120, 4), &scan);
  Paint(215, 100, Image(60, 12, 40), &scan);
  const auto found = FindFilmOnBed(Overview(scan));
  ASSERT_FALSE(found.empty());
  EXPECT_LT((found[0].centre_px - Vector2d(1600, 1200)).norm(), 40);
}

TEST(FindFilmOnBed, TwoFramesAreTwoRegionsTheLargestFirst) {
  Image scan(400, 300, 250);
  Paint(20, 30, RenderTexture(100, 100, 5), &scan);
  Paint(200, 60, RenderTexture(120, 110, 6), &scan);
  const auto found = FindFilmOnBed(Overview(scan));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_GT(found[0].centre_px.x(), 2000);
}

TEST(FindFilmOnBed, AScanFilledByTheFilmHasNoBed) {
  EXPECT_TRUE(FindFilmOnBed(Overview(RenderTexture(300, 300, 7))).empty());
  EXPECT_TRUE(FindFilmOnBed(Overview(Image(300, 300, 9))).empty());
}

class FrameOnABed : public testing::TestWithParam<float> {};

TEST_P(FrameOnABed, IsOrientedWithAndWithoutItsPixelSize) {
  constexpr double kPixelMm = 0.1;
  FilmFrameSpec spec;
  spec.camera = RingCamera(26, 60);
  spec.pixel_mm = kPixelMm;
  spec.turn_rad = 0.01;
  spec.seed = 21;
  const FilmFrame frame = RenderFilmFrame(spec);
  const Vector2d corner(1210, 90);
  Image bed(2100, 1700, GetParam());  // 21 x 17 cm
  Paint(1210, 90, frame.scan, &bed);
  const TemporaryFolder folder;
  const std::string path = folder / "bed.png";
  WriteScan(path, bed);
  for (const auto& size_um : {std::optional<double>(1e3 * kPixelMm), std::optional<double>()}) {
    InteriorOptions options;
    options.pixel_size_um = size_um;
    options.orientation = ScanOrientation::kR0;
    const InteriorResult result =
        OrientInterior(Raster::Open(path), spec.camera, ShapesOf(spec.camera), options);
    // Four marks in a square may be those of a camera of any size.
    ASSERT_EQ(result.status, size_um ? Status::kOk : Status::kWeak)
        << JoinedSentences(result.findings);
    for (size_t i = 0; i < result.marks.size(); ++i) {
      ASSERT_TRUE(result.marks[i].pixel);
      EXPECT_LT((*result.marks[i].pixel - corner - frame.mark_pixels[i]).norm(), 0.25);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(WhiteBlackAndGrey, FrameOnABed, testing::Values(250.0f, 3.0f, 120.0f));

}  // namespace
}  // namespace orient::interior
