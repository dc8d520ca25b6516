#include "core/raster/window_reader.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/colour_raster.h"
#include "core/raster/raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr int kSide = 2000;  // 12 MB in three bands

// Colours that differ from place to place.
void WriteAs(const char* format, const std::string& path, int bands, GDALDataType type,
             std::vector<const char*> options = {}) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  GDALDriver* memory = GetGDALDriverManager()->GetDriverByName("MEM");
  const GDALDatasetUniquePtr image(memory->Create("", kSide, kSide, bands, type, nullptr));
  std::vector<std::uint16_t> row(kSide);
  for (int band = 1; band <= bands; ++band)
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x)
        row[static_cast<std::size_t>(x)] =
            static_cast<std::uint16_t>((x / 16 * 31 + y / 16 * 17 + band * 40) % 250);
      ASSERT_EQ(image->GetRasterBand(band)->RasterIO(GF_Write, 0, y, kSide, 1, row.data(), kSide, 1,
                                                     GDT_UInt16, 0, 0),
                CE_None);
    }
  options.push_back(nullptr);
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName(format);
  ASSERT_NE(
      GDALDatasetUniquePtr(driver->CreateCopy(
          path.c_str(), image.get(), FALSE, const_cast<char**>(options.data()), nullptr, nullptr)),
      nullptr);
}

const PixelWindow kLow{100, 1700, 90, 80}, kHigh{1500, 60, 90, 80}, kMiddle{700, 900, 33, 44};

TEST(WindowReader, AfterItsDecodingNothingIsReadFromTheFileAnyMore) {
  const TemporaryFolder folder;
  WriteAs("JPEG", folder / "a.jpg", 3, GDT_Byte);
  WriteAs("PNG", folder / "a.png", 1, GDT_UInt16);
  WriteAs("GTiff", folder / "strip.tif", 1, GDT_UInt16,
          {"COMPRESS=DEFLATE", "BLOCKYSIZE=2000", "PREDICTOR=2"});
  for (const char* file : {"a.jpg", "a.png", "strip.tif"}) {
    const std::string path = folder / file;
    const Image expected = Raster::Open(path).ReadGrey(kMiddle).image;
    const Raster raster = Raster::Open(path);
    raster.ReadGrey(kLow);
    const Image high = raster.ReadGrey(kHigh).image;
    fs::resize_file(path, 0);
    EXPECT_EQ(raster.ReadGrey(kMiddle).image.values, expected.values) << file;
    EXPECT_EQ(raster.ReadGrey(kHigh).image.values, high.values) << file;
  }
}

TEST(WindowReader, ColoursAreKeptToo) {
  const TemporaryFolder folder;
  WriteAs("JPEG", folder / "a.jpg", 3, GDT_Byte);
  const auto expected = ColourRaster::Open(folder / "a.jpg")->Read(kMiddle);
  const auto raster = ColourRaster::Open(folder / "a.jpg");
  raster->Read(kLow);
  raster->Read(kHigh);
  fs::resize_file(folder / "a.jpg", 0);
  const auto read = raster->Read(kMiddle);
  for (std::size_t band = 0; band < 3; ++band)
    EXPECT_EQ(read[band].image.values, expected[band].image.values);
}

TEST(WindowReader, WhatLiesAboveTheDamageIsRead) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.jpg";
  WriteAs("JPEG", path, 3, GDT_Byte);
  const Image expected = Raster::Open(path).ReadGrey(kHigh).image;
  fs::resize_file(path, fs::file_size(path) * 3 / 4);
  const Raster raster = Raster::Open(path);
  raster.ReadGrey(kMiddle);
  for (int turn = 0; turn < 2; ++turn) {
    EXPECT_EQ(raster.ReadGrey(kHigh).image.values, expected.values);
    ExpectError<InputError>([&] { raster.ReadGrey(kLow); }, {path, "row 1700"});
  }
}

TEST(WindowReader, WithoutRoomTheFileIsReadAgain) {
  const TemporaryFolder folder;
  WriteAs("JPEG", folder / "a.jpg", 3, GDT_Byte);
  const Image expected = Raster::Open(folder / "a.jpg").ReadGrey(kHigh).image;
  setenv("TMPDIR", (folder / "absent").c_str(), 1);
  const Raster raster = Raster::Open(folder / "a.jpg");
  raster.ReadGrey(kLow);
  const Image read = raster.ReadGrey(kHigh).image;
  unsetenv("TMPDIR");
  EXPECT_EQ(read.values, expected.values);
}

}  // namespace
}  // namespace orient
