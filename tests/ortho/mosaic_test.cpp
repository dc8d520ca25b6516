#include "ortho/mosaic.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/raster/band_raster.h"
#include "ortho/new_cog.h"
#include "tests/support/expect_error.h"
#include "tests/support/few_files.h"
#include "tests/support/shared_data.h"

namespace orient::ortho {
namespace {

const Crs kCrs = Crs::Parse("EPSG:32635", "test");
const BandFormat kGrey = {1, 1, 8, {1}};

class Mosaic : public ::testing::Test {
 protected:
  // An orthophoto of one grey value around its nadir, without data in a square hole of `hole` px in
  // the middle of its eastern half.
  void Add(const std::string& name, double nadir_x, float value, int hole = 0,
           const BandFormat& format = kGrey) {
    constexpr double kHalf = 400;
    MosaicPart part{name,
                    folder_ / (name + ".tif"),
                    MapGrid::Around({nadir_x - kHalf, -kHalf, nadir_x + kHalf, kHalf}, 1),
                    {nadir_x, 0}};
    NewCog file(part.path, format, part.grid, kCrs);
    for (const PixelWindow& tile : TilesOf(part.grid)) {
      std::vector<std::uint8_t> mask;
      for (int row = 0; row < tile.height; ++row)
        for (int col = 0; col < tile.width; ++col) {
          const bool lost = std::abs(tile.col + col - 600) < hole / 2 &&
                            std::abs(tile.row + row - 400) < hole / 2;
          mask.push_back(lost ? 0 : 255);
        }
      file.Write(tile,
                 std::vector<Image>(static_cast<std::size_t>(format.bands),
                                    Image(tile.width, tile.height, value)),
                 mask);
    }
    file.Finish({}, 1);
    parts_.push_back(part);
    outlines_.push_back({name,
                         part.nadir_m,
                         {{nadir_x - kHalf, -kHalf},
                          {nadir_x + kHalf, -kHalf},
                          {nadir_x + kHalf, kHalf},
                          {nadir_x - kHalf, kHalf},
                          {nadir_x - kHalf, -kHalf}}});
  }

  void Make(const Seamlines& seamlines, int threads = 0) {
    grid_ = MakeMosaic(parts_, seamlines, kCrs, {{"ORIENT_NOTE", "test"}}, threads,
                       folder_ / "mosaic.tif", nullptr);
  }

  // The value at a place, -1 without data.
  float At(double x, double y) const {
    const BandRaster mosaic = BandRaster::Open(folder_ / "mosaic.tif");
    const PixelWindow pixel{static_cast<int>(x - static_cast<double>(grid_.west)),
                            static_cast<int>(static_cast<double>(grid_.north) - y), 1, 1};
    return mosaic.ReadMask(pixel).front() == 0 ? -1 : mosaic.Read(pixel).front().values.front();
  }

  TemporaryFolder folder_;
  std::vector<MosaicPart> parts_;
  std::vector<SeamPhoto> outlines_;
  MapGrid grid_;
};

TEST_F(Mosaic, ShowsEachPhotoUpToItsSeamline) {
  Add("a", 0, 10);
  Add("b", 500, 20);
  Make(Seamlines::ByNearestNadir(outlines_));
  EXPECT_EQ(grid_.width, 1300);
  EXPECT_EQ(At(-399.5, 0.5), 10);
  EXPECT_EQ(At(249.5, 100.5), 10);
  EXPECT_EQ(At(250.5, 100.5), 20);
  EXPECT_EQ(At(899.5, -399.5), 20);
  EXPECT_EQ(BandRaster::Open(folder_ / "mosaic.tif").Metadata("ORIENT_NOTE"), "test");
}

TEST_F(Mosaic, WhatAPhotoDoesNotShowComesFromTheNearestThatDoes) {
  Add("a", 0, 10, 60);
  Add("far", 520, 30);
  Add("b", 450, 20);
  Make(Seamlines::ByNearestNadir(outlines_));
  EXPECT_EQ(At(150.5, 0.5), 10);
  EXPECT_EQ(At(200.5, 0.5), 20) << "in the hole of a";
  parts_ = {parts_[0]};
  Make(Seamlines::ByNearestNadir({outlines_[0]}));
  EXPECT_EQ(At(200.5, 0.5), -1) << "nobody else shows it";
}

TEST_F(Mosaic, EditedSeamlinesCount) {
  Add("a", 0, 10);
  Add("b", 500, 20);
  // All of the overlap to a.
  SeamPhoto rest = outlines_[1];
  for (Eigen::Vector2d& point : rest.outline_m) point.x() = std::max(point.x(), 400.0);
  Seamlines::ByNearestNadir({outlines_[0], rest}).Write(folder_ / "edited.gpkg", kCrs);
  Make(Seamlines::FromFile(folder_ / "edited.gpkg", kCrs));
  EXPECT_EQ(At(399.5, 0.5), 10);
  EXPECT_EQ(At(400.5, 0.5), 20);
}

TEST_F(Mosaic, ShowsPartsInTheirTonesAsFarAsTheFormatGoes) {
  Add("a", 0, 10);
  Add("b", 500, 200);
  parts_[0].tones = {{1.5, 2.6}};
  parts_[1].tones = {{1.5, 0}};
  Make(Seamlines::ByNearestNadir(outlines_));
  EXPECT_EQ(At(0.5, 0.5), 18) << "17.6";
  EXPECT_EQ(At(500.5, 0.5), 255) << "300";
  parts_[1].tones = {{1, -300}};
  Make(Seamlines::ByNearestNadir(outlines_));
  EXPECT_EQ(At(500.5, 0.5), 0) << "black, not without data";
}

TEST_F(Mosaic, IsTheSameForAnyNumberOfThreads) {
  Add("a", 0, 10, 60);
  Add("b", 500, 20);
  Make(Seamlines::ByNearestNadir(outlines_), 1);
  const std::string one = ReadFile(folder_ / "mosaic.tif");
  Make(Seamlines::ByNearestNadir(outlines_), 2);
  EXPECT_EQ(ReadFile(folder_ / "mosaic.tif"), one);
}

TEST_F(Mosaic, MayHaveMorePartsThanFilesMayBeOpen) {
  ORIENT_REQUIRE_FEW_FILES();
  const FewFiles few(110);
  for (int i = 0; i < 150; ++i) Add(std::to_string(i), 20.0 * i, static_cast<float>(i));
  Make(Seamlines::ByNearestNadir(outlines_));
  for (const int i : {0, 71, 149}) EXPECT_EQ(At(20.0 * i + 0.5, 0.5), static_cast<float>(i));
}

TEST_F(Mosaic, WhatDoesNotBelongTogetherIsRefused) {
  Add("a", 0, 10);
  Add("b", 500, 20);
  const auto seamlines = Seamlines::ByNearestNadir(outlines_);
  parts_.pop_back();
  ExpectError<InputError>([&] { Make(seamlines); }, {"photo b", "delete its polygon"});
  Add("c", 500, 20, 0, {3, 1, 8, {3, 4, 5}});
  outlines_.erase(outlines_.begin() + 1);
  ExpectError<InputError>([&] { Make(Seamlines::ByNearestNadir(outlines_)); },
                          {"a.tif", "c.tif", "bands"});
  parts_.back().grid.gsd_m = 2;
  parts_.back().path = parts_.front().path;
  ExpectError<InputError>([&] { Make(Seamlines::ByNearestNadir(outlines_)); }, {"pixel size"});
  parts_.clear();
  ExpectError<InputError>([&] { Make(seamlines); }, {"no orthophoto"});
}

}  // namespace
}  // namespace orient::ortho
