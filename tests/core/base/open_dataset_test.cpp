#include "core/base/open_dataset.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// Holds no pixel until one is written: some hundred bytes, whatever its size.
void WriteSparseTiff(const std::string& path, int side, std::vector<const char*> options) {
  RegisterGdalDrivers();
  options.insert(options.begin(), "SPARSE_OK=TRUE");
  options.push_back(nullptr);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  const GDALDatasetUniquePtr file(
      driver->Create(path.c_str(), side, side, 1, GDT_Byte, const_cast<char**>(options.data())));
  ASSERT_NE(file, nullptr);
}

std::string VrtOf(const std::string& source) {
  return "<VRTDataset rasterXSize=\"8\" rasterYSize=\"8\"><VRTRasterBand dataType=\"Byte\" "
         "band=\"1\"><SimpleSource><SourceFilename>" +
         source + "</SourceFilename></SimpleSource></VRTRasterBand></VRTDataset>";
}

TEST(OpenDataset, AVirtualRasterIsOneByItsNameOnly) {
  const TemporaryFolder folder;
  const QuietGdal quiet;
  WriteSparseTiff(folder / "pixels.tif", 8, {});
  WriteFileAtomically(folder / "honest.vrt", VrtOf(folder / "pixels.tif"));
  WriteFileAtomically(folder / "photo.tif", VrtOf(folder / "pixels.tif"));
  EXPECT_NE(OpenRasterDataset(folder / "honest.vrt"), nullptr);
  EXPECT_EQ(OpenRasterDataset(folder / "photo.tif"), nullptr);
  ExpectError<InputError>([&] { Raster::Open(folder / "photo.tif"); }, {folder / "photo.tif"});
}

TEST(OpenDataset, AVirtualVectorFileIsOneByItsNameOnly) {
  const TemporaryFolder folder;
  const QuietGdal quiet;
  WriteFileAtomically(folder / "points.csv", "filename,x,y\na,1,2\n");
  const std::string vrt = "<OGRVRTDataSource><OGRVRTLayer name=\"points\"><SrcDataSource>" +
                          (folder / "points.csv") +
                          "</SrcDataSource></OGRVRTLayer></OGRVRTDataSource>";
  WriteFileAtomically(folder / "honest.vrt", vrt);
  WriteFileAtomically(folder / "index.gpkg", vrt);
  EXPECT_NE(OpenVectorDataset(folder / "points.csv"), nullptr);
  EXPECT_NE(OpenVectorDataset(folder / "honest.vrt"), nullptr);
  EXPECT_EQ(OpenVectorDataset(folder / "index.gpkg"), nullptr);
}

TEST(OpenDataset, OneHugeTileIsRefusedWithTheRemedy) {
  const TemporaryFolder folder;
  WriteSparseTiff(folder / "tile.tif", 40000,
                  {"TILED=YES", "BLOCKXSIZE=40000", "BLOCKYSIZE=40000", "COMPRESS=DEFLATE"});
  ExpectError<InputError>([&] { Raster::Open(folder / "tile.tif"); },
                          {folder / "tile.tif", "TILED=YES"});
}

TEST(OpenDataset, ALargeScanOfOneUncompressedStripIsRead) {
  const TemporaryFolder folder;
  WriteSparseTiff(folder / "strip.tif", 20000, {"BLOCKYSIZE=20000"});
  const Raster scan = Raster::Open(folder / "strip.tif");
  EXPECT_EQ(scan.ReadGrey({10000, 19990, 8, 8}).image.width, 8);
}

TEST(OpenScan, DeclaredSizesThatNoScanHasAreRefused) {
  const TemporaryFolder folder;
  WriteSparseTiff(
      folder / "long.tif", 400000,
      {"TILED=YES", "BIGTIFF=YES", "BLOCKXSIZE=65536", "BLOCKYSIZE=2048", "COMPRESS=DEFLATE"});
  EXPECT_EQ(Raster::Open(folder / "long.tif").Width(), 400000);  // of a country's orthophoto
  ExpectError<InputError>([&] { Raster::OpenScan(folder / "long.tif"); },
                          {folder / "long.tif", "400000 x 400000"});
}

TEST(OpenScan, PixelsThatTheFileCannotHoldAreRefused) {
  const TemporaryFolder folder;
  WriteSparseTiff(folder / "empty.tif", 40000,
                  {"TILED=YES", "BLOCKXSIZE=8192", "BLOCKYSIZE=8192", "COMPRESS=DEFLATE"});
  ExpectError<InputError>([&] { Raster::OpenScan(folder / "empty.tif"); },
                          {folder / "empty.tif", "bytes"});
}

}  // namespace
}  // namespace orient
