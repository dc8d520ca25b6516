#include "block/inputs/digest.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "tests/support/shared_data.h"
#include "tools/simulate/geotiff.h"

namespace orient::block {
namespace {

void WriteHeights(const std::string& path, float changed) {
  // Large enough that its middle lies in none of the pieces that are looked at.
  std::vector<float> heights(1000 * 1000, 120);
  heights[300 * 1000 + 500] = changed;
  simulation::WriteFloatTiff(path, 1000, 1000, heights,
                             {500000, 5000000, 10, Crs::Parse("EPSG:32635", "test")});
}

TEST(Digest, IsTheSameInPiecesAndThatOfItsDefinition) {
  EXPECT_EQ(Digest(""), "cbf29ce484222325");  // FNV-1a's test vectors
  EXPECT_EQ(Digest("foobar"), "85944171f73967e8");
  DigestOfPieces pieces;
  for (const char* piece : {"foo", "", "bar"}) pieces.Add(piece);
  EXPECT_EQ(pieces.Digits(), Digest("foobar"));
}

TEST(DigestOf, TellsWhichInputHasWhichContent) {
  const std::string digest = DigestOf({{"camera", "a"}, {"scan", "b"}});
  EXPECT_EQ(digest.size(), 16u);
  EXPECT_EQ(DigestOf({{"scan", "b"}, {"camera", "a"}}), digest);
  EXPECT_NE(DigestOf({{"camera", "b"}, {"scan", "a"}}), digest);
  EXPECT_NE(DigestOf({{"camera", "a"}}), digest);
  EXPECT_NE(DigestOf({{"camera", "a"}, {"dem", "b"}}), digest);
}

TEST(DigestOfFile, DoesNotWaitForAPipe) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe.tif").c_str(), 0600), 0);
  EXPECT_EQ(DigestOfFile(folder / "pipe.tif"), "");
}

TEST(DigestOfRaster, IsTheSameForTheSameFile) {
  const TemporaryFolder folder;
  WriteHeights(folder / "dem.tif", 120);
  const std::string digest = DigestOfRaster(folder / "dem.tif");
  EXPECT_EQ(digest.size(), 16u);
  EXPECT_EQ(DigestOfRaster(folder / "dem.tif"), digest);
  EXPECT_EQ(DigestOfRaster(folder / "none.tif"), "");
}

TEST(DigestOfRaster, NoticesHeightsCorrectedInTheMiddleOfAFile) {
  const TemporaryFolder folder;
  WriteHeights(folder / "dem.tif", 120);
  const std::string digest = DigestOfRaster(folder / "dem.tif");
  WriteHeights(folder / "dem.tif", 121);
  std::filesystem::last_write_time(
      folder / "dem.tif",
      std::filesystem::last_write_time(folder / "dem.tif") + std::chrono::seconds(2));
  EXPECT_NE(DigestOfRaster(folder / "dem.tif"), digest);
}

TEST(DigestOfRaster, NoticesWhatAVirtualRasterIsPutTogetherFrom) {
  const TemporaryFolder folder;
  WriteHeights(folder / "dem.tif", 120);
  WriteFileAtomically(folder / "dem.vrt",
                      "<VRTDataset rasterXSize=\"1000\" rasterYSize=\"1000\">"
                      "<GeoTransform>500000, 10, 0, 5000000, 0, -10</GeoTransform>"
                      "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                      "<SourceFilename relativeToVRT=\"1\">dem.tif</SourceFilename>"
                      "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
  WriteFileAtomically(folder / "outer.vrt",
                      "<VRTDataset rasterXSize=\"1000\" rasterYSize=\"1000\">"
                      "<GeoTransform>500000, 10, 0, 5000000, 0, -10</GeoTransform>"
                      "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource>"
                      "<SourceFilename relativeToVRT=\"1\">dem.vrt</SourceFilename>"
                      "<SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>");
  const std::string digest = DigestOfRaster(folder / "dem.vrt");
  const std::string outer = DigestOfRaster(folder / "outer.vrt");
  ASSERT_EQ(digest.size(), 16u);
  std::filesystem::last_write_time(
      folder / "dem.tif",
      std::filesystem::last_write_time(folder / "dem.tif") + std::chrono::seconds(2));
  EXPECT_NE(DigestOfRaster(folder / "dem.vrt"), digest);
  EXPECT_NE(DigestOfRaster(folder / "outer.vrt"), outer);
}

}  // namespace
}  // namespace orient::block
