#include "ortho/mosaic_cells.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "ortho/new_cog.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::ortho {
namespace {

const Crs kCrs = Crs::Parse("EPSG:32635", "test");

class Cells : public ::testing::Test {
 protected:
  // An orthophoto with the grey value of its pixel's column on the map modulo 200; without data
  // west of `from_col`.
  MosaicPart Write(const MapGrid& grid, int from_col, int bands = 1) {
    MosaicPart part{"photo", folder_ / (std::to_string(++count_) + ".tif"), grid, {0, 0}};
    NewCog file(part.path, {bands, 1, 8, std::vector<int>(static_cast<std::size_t>(bands), 1)},
                grid, kCrs);
    for (const PixelWindow& tile : TilesOf(grid)) {
      Image values(tile.width, tile.height);
      std::vector<std::uint8_t> mask;
      for (int row = 0; row < tile.height; ++row)
        for (int col = 0; col < tile.width; ++col) {
          const std::int64_t at = grid.west + tile.col + col;
          values.At(col, row) = static_cast<float>((at % 200 + 200) % 200);
          mask.push_back(at < from_col ? 0 : 255);
        }
      file.Write(tile, std::vector<Image>(static_cast<std::size_t>(bands), values), mask);
    }
    file.Finish({}, 1);
    return part;
  }

  TemporaryFolder folder_;
  int count_ = 0;
};

MapGrid Grid(std::int64_t west, std::int64_t north, int width, int height) {
  MapGrid grid;
  grid.gsd_m = 0.5;
  grid.west = west;
  grid.north = north;
  grid.width = width;
  grid.height = height;
  return grid;
}

TEST_F(Cells, AreTheMeansOfTheirPixelsWestAndEastOfTheOrigin) {
  // Cells of 2 px, since 1500 px are more than 1000; west of -1 no data, so that the cell of
  // columns -2 and -1 has half of its pixels.
  const MosaicPart part = Write(Grid(-701, 33, 1500, 40), -1);
  const PhotoCells cells = ReadCells({part}, 1, nullptr).front();
  EXPECT_EQ(cells.grid.gsd_m, 1);
  EXPECT_EQ(cells.grid.west, -351);
  EXPECT_EQ(cells.grid.north, 17);
  EXPECT_EQ(cells.grid.width, 751);
  EXPECT_EQ(cells.grid.height, 21);
  EXPECT_FALSE(cells.Has(349, 5)) << "columns -4 and -3";
  EXPECT_EQ(cells.bands[0].At(350, 5), 199) << "column -1 alone";
  EXPECT_EQ(cells.bands[0].At(351, 5), 0.5);
  EXPECT_EQ(cells.bands[0].At(351 + 50, 20), 100.5);
  EXPECT_TRUE(cells.Has(749, 0)) << "the upper half of the first row's cells lies outside";
}

TEST_F(Cells, OfSeveralPhotosCoincide) {
  const MosaicPart west = Write(Grid(0, 0, 1200, 30), -1000000),
                   east = Write(Grid(601, 7, 1100, 30), -1000000);
  const std::vector<PhotoCells> cells = ReadCells({west, east}, 2, nullptr);
  const auto [a, b] = Common(cells[0].grid, cells[1].grid);
  EXPECT_EQ(a.width, 300);
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(cells[0].bands[0].At(a.col + 7, a.row + 2), cells[1].bands[0].At(b.col + 7, b.row + 2));
  EXPECT_EQ(Common(cells[0].grid, Grid(5000, 0, 10, 10)).in_first.width, 0);
}

TEST_F(Cells, OfManyPhotosAreLarger) {
  const MosaicPart part{"photo", "", Grid(0, 0, 1000, 1000), {0, 0}};
  EXPECT_EQ(CellSide({part}, 1), 1);
  EXPECT_EQ(CellSide(std::vector<MosaicPart>(64, part), 1), 1);
  EXPECT_EQ(CellSide(std::vector<MosaicPart>(65, part), 1), 2);
  EXPECT_EQ(CellSide(std::vector<MosaicPart>(64, part), 4), 2);
}

TEST_F(Cells, OfPhotosFarApartAreLarger) {
  const MosaicPart here{"a", "", Grid(0, 0, 1000, 1000), {0, 0}},
      there{"b", "", Grid(39000, -39000, 1000, 1000), {0, 0}};
  EXPECT_EQ(CellSide({here, there}, 1), 10) << "40,000 x 40,000 px";
}

TEST_F(Cells, OfOtherBandsAreRefused) {
  const MosaicPart grey = Write(Grid(0, 0, 20, 20), 0), colour = Write(Grid(0, 0, 20, 20), 0, 3);
  ExpectError<InputError>([&] { ReadCells({grey, colour}, 1, nullptr); }, {"2.tif", "bands"});
}

}  // namespace
}  // namespace orient::ortho
