#include "block/inputs/exposure_date.h"

#include <gdal_priv.h>
#include <gtest/gtest.h>

#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

TEST(ExposureDate, IsTheDateOfTheTag) {
  EXPECT_EQ(DateOfTag("1998:07:30 11:02:45"), "1998-07-30");
  EXPECT_EQ(DateOfTag("2015-01-02T10:00:00"), "2015-01-02");
}

TEST(ExposureDate, OfATagThatIsNoDateIsUnknown) {
  for (const char* tag : {"", "0000:00:00 00:00:00", "    :  :     :  :  ", "1998:13:01 00:00:00",
                          "1998:07:00", "July 1998", "98:07:30"})
    EXPECT_FALSE(DateOfTag(tag)) << tag;
}

TEST(ExposureDate, OfADigitalPhotoIsItsFilesAndOfFilmUnknown) {
  const TemporaryFolder folder;
  const std::string path = folder / "4711.tif", plain = folder / "4712.tif";
  GDALAllRegister();
  GDALDriver* tiff = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDatasetUniquePtr(tiff->Create(path.c_str(), 8, 8, 1, GDT_Byte, nullptr))
      ->SetMetadataItem("TIFFTAG_DATETIME", "2015:03:09 08:11:12");
  GDALDatasetUniquePtr(tiff->Create(plain.c_str(), 8, 8, 1, GDT_Byte, nullptr));
  EXPECT_EQ(ExposureDate(path, CameraKind::kDigital), "2015-03-09");
  EXPECT_FALSE(ExposureDate(path, CameraKind::kFilm)) << "that is when it was scanned";
  EXPECT_FALSE(ExposureDate(plain, CameraKind::kDigital));
  EXPECT_FALSE(ExposureDate(folder / "none.tif", CameraKind::kDigital));
}

}  // namespace
}  // namespace orient::block
