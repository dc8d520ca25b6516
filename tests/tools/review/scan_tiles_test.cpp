#include "tools/review/scan_tiles.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/raster/png_bands.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// Brightness grows to the right by `step` per column.
void WriteRamp(const std::string& path, int width, int height, GDALDataType type, double step) {
  GDALAllRegister();
  GDALDatasetUniquePtr dataset(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
      path.c_str(), width, height, 1, type, nullptr));
  std::vector<double> line(static_cast<size_t>(width));
  for (int col = 0; col < width; ++col) line[static_cast<size_t>(col)] = step * col;
  for (int row = 0; row < height; ++row)
    ASSERT_EQ(dataset->GetRasterBand(1)->RasterIO(GF_Write, 0, row, width, 1, line.data(), width, 1,
                                                  GDT_Float64, 0, 0, nullptr),
              CE_None);
}

class ScanTilesTest : public testing::Test {
 protected:
  Image TileOf(ScanTiles* tiles, const TilePlace& place) const {
    const auto png = tiles->Tile("a", place);
    if (png == nullptr) return {};
    return DecodePngBands({png->begin(), png->end()}).at(0);
  }

  TemporaryFolder folder_;
};

TEST_F(ScanTilesTest, ShowTheScanAtItsPlace) {
  WriteRamp(folder_ / "a.tif", 300, 260, GDT_Byte, 0.8);
  ScanTiles tiles({{"a", folder_ / "a.tif"}});
  const auto size = tiles.Size("a");
  ASSERT_TRUE(size);
  EXPECT_EQ(size->width, 300);
  EXPECT_EQ(size->height, 260);
  EXPECT_EQ(size->levels, 2);
  const Image first = TileOf(&tiles, {0, 0, 0});
  EXPECT_EQ(first.width, 256);
  EXPECT_EQ(first.At(100, 30), 80);
  const Image second = TileOf(&tiles, {0, 1, 0});
  EXPECT_EQ(second.At(30, 100), 229) << "0.8 * 286";
  EXPECT_EQ(second.width, 44) << "the scan ends there";
  EXPECT_EQ(TileOf(&tiles, {0, 0, 1}).height, 4);
  const Image whole = TileOf(&tiles, {1, 0, 0});
  EXPECT_NEAR(whole.At(100, 60), 0.8 * 200.5, 1);
}

TEST_F(ScanTilesTest, SixteenBitsAreStretchedOverTheScan) {
  WriteRamp(folder_ / "a.tif", 1000, 40, GDT_UInt16, 4);
  ScanTiles tiles({{"a", folder_ / "a.tif"}});
  const Image left = TileOf(&tiles, {0, 0, 0}), right = TileOf(&tiles, {0, 3, 0});
  EXPECT_EQ(left.At(2, 10), 0);
  EXPECT_GT(left.At(250, 10), 50);
  EXPECT_EQ(right.At(231, 10), 255);
}

TEST_F(ScanTilesTest, CoarseTilesOfLargeScansAgreeWithFineOnes) {
  WriteRamp(folder_ / "a.tif", 5000, 4200, GDT_Byte, 0.05);
  ScanTiles tiles({{"a", folder_ / "a.tif"}});
  ASSERT_EQ(tiles.Size("a")->levels, 6);
  const Image whole = TileOf(&tiles, {5, 0, 0});  // 32 pixels to one
  EXPECT_NEAR(whole.At(0, 0), 0.05 * 16, 1);
  EXPECT_NEAR(whole.At(100, 120), 0.05 * 3216, 1);
  EXPECT_EQ(whole.width, 157) << "5000 / 32";
  EXPECT_EQ(whole.height, 132) << "4200 / 32";
}

TEST_F(ScanTilesTest, AreAbsentOutsideAndOfUnknownScans) {
  WriteRamp(folder_ / "a.tif", 300, 260, GDT_Byte, 0.8);
  ScanTiles tiles({{"a", folder_ / "a.tif"}});
  EXPECT_FALSE(tiles.Size("b"));
  EXPECT_EQ(tiles.Tile("b", {0, 0, 0}), nullptr);
  for (const TilePlace& place : {TilePlace{-1, 0, 0}, TilePlace{2, 0, 0}, TilePlace{0, 2, 0},
                                 TilePlace{0, 0, -1}, TilePlace{1, 2147483647, 2147483647}})
    EXPECT_EQ(tiles.Tile("a", place), nullptr);
}

TEST_F(ScanTilesTest, AMissingScanIsNamed) {
  ScanTiles tiles({{"a", folder_ / "gone.tif"}});
  ExpectError<InputError>([&] { tiles.Size("a"); }, {"gone.tif"});
}

TEST_F(ScanTilesTest, TheSameTileIsMadeOnce) {
  WriteRamp(folder_ / "a.tif", 300, 260, GDT_Byte, 0.8);
  ScanTiles tiles({{"a", folder_ / "a.tif"}});
  const auto png = tiles.Tile("a", {0, 0, 0});
  EXPECT_EQ(tiles.Tile("a", {0, 0, 0}), png);
}

}  // namespace
}  // namespace orient
