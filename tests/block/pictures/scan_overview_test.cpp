// Overviews of scans: what is drawn where, by the colours of the picture's pixels.
#include "block/pictures/scan_overview.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/raster/raster.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

using Eigen::Vector2d;

class ScanOverview : public testing::Test {
 protected:
  // Of an even scan of 1800 x 900 pixels: a pixel of the picture is two of the scan.
  std::array<int, 3> ColourAt(const std::vector<OverviewItem>& items, int col, int row) {
    WriteScan(folder_ / "scan.png", Image(1800, 900, 100));
    WriteScanOverview(folder_ / "o.png", Raster::Open(folder_ / "scan.png"), items);
    const Raster picture = Raster::Open(folder_ / "o.png");
    EXPECT_EQ(picture.Width(), 900);
    EXPECT_EQ(picture.Height(), 450);
    const auto is = [grey = static_cast<double>(picture.ReadGrey({col, row, 1, 1}).image.At(0, 0))](
                        double red, double green, double blue) {
      return std::abs(grey - (0.299 * red + 0.587 * green + 0.114 * blue)) < 1.5;
    };
    // Used, rejected, not found.
    return {is(60, 220, 60), is(255, 140, 0), is(255, 60, 60)};
  }

  TemporaryFolder folder_;
};

TEST_F(ScanOverview, AThumbnailIsTheScanMadeSmall) {
  Image halves(1800, 900, 50);
  for (int row = 0; row < 900; ++row) std::fill_n(halves.Row(row) + 900, 900, 200.0f);
  WriteScan(folder_ / "scan.png", halves);
  WriteThumbnail(folder_ / "t.png", Raster::Open(folder_ / "scan.png"));
  const Raster picture = Raster::Open(folder_ / "t.png");
  EXPECT_EQ(picture.Width(), 240);
  EXPECT_EQ(picture.Height(), 120);
  const Image grey = picture.ReadGrey({0, 0, 240, 120}).image;
  EXPECT_LT(grey.At(60, 60), grey.At(180, 60));
}

TEST_F(ScanOverview, AUsedMarkIsAGreenCrossOpenAtItsCentre) {
  const std::vector<OverviewItem> items = {
      {"", OverviewState::kUsed, std::nullopt, std::nullopt, Vector2d(400, 300)}};
  EXPECT_TRUE(ColourAt(items, 206, 150)[0]);
  EXPECT_TRUE(ColourAt(items, 200, 144)[0]);
  EXPECT_EQ(ColourAt(items, 200, 150), (std::array<int, 3>{0, 0, 0}));
}

TEST_F(ScanOverview, AMissingMarkIsARedFrameAndACircleWhereItIsExpected) {
  const std::vector<OverviewItem> items = {{"", OverviewState::kNotFound,
                                            SearchedWindow{1000, 200, 200, 100},
                                            Vector2d(1100, 250), std::nullopt}};
  EXPECT_TRUE(ColourAt(items, 520, 100)[2]);  // upper edge
  EXPECT_TRUE(ColourAt(items, 500, 120)[2]);  // left edge
  EXPECT_TRUE(ColourAt(items, 554, 125)[2]);  // circle
  EXPECT_EQ(ColourAt(items, 550, 125), (std::array<int, 3>{0, 0, 0}));
}

TEST_F(ScanOverview, ARejectedPatchIsOrangeFromWhereItWasExpected) {
  ExteriorResult result;
  PatchResult patch;
  patch.state = PatchState::kRejected;
  patch.predicted = Vector2d(200, 400);
  patch.pixel = Vector2d(400, 400);
  PatchResult hidden = patch;
  hidden.state = PatchState::kNotVisible;
  result.patches = {patch, hidden};
  const auto items = OverviewOf(result);
  ASSERT_EQ(items.size(), 1u);
  EXPECT_TRUE(ColourAt(items, 150, 200)[1]);
}

TEST_F(ScanOverview, WindowsBeyondTheScanAreCutOff) {
  const std::vector<OverviewItem> items = {{"far", OverviewState::kNotFound,
                                            SearchedWindow{-500, -500, 5000, 800},
                                            Vector2d(-90, 1e7), std::nullopt}};
  EXPECT_TRUE(ColourAt(items, 450, 150)[2]);  // lower edge
}

TEST(OverviewOfMarks, HasAllMarksWithTheirStates) {
  InteriorResult result;
  result.marks.resize(3);
  result.marks[0].state = MarkState::kUsed;
  result.marks[1].state = MarkState::kRejected;
  result.marks[2].state = MarkState::kMissing;
  result.marks[2].window = SearchedWindow{1, 2, 3, 4};
  const auto items = OverviewOf(result);
  ASSERT_EQ(items.size(), 3u);
  EXPECT_EQ(items[0].state, OverviewState::kUsed);
  EXPECT_EQ(items[1].state, OverviewState::kRejected);
  EXPECT_EQ(items[2].state, OverviewState::kNotFound);
  EXPECT_TRUE(items[2].window);
}

}  // namespace
}  // namespace orient::block
