#include "core/base/gdal_faults.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <fcntl.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>
#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "core/base/atomic_write.h"
#include "core/base/environment_error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/overviews.h"
#include "core/raster/raster.h"
#include "core/terrain/dem_raster.h"
#include "tests/support/expect_error.h"
#include "tests/support/few_files.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// With an overview in a file of its own, of another grey value.
void WriteTiff(const std::string& path) {
  RegisterGdalDrivers();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDatasetUniquePtr file(driver->Create(path.c_str(), 512, 512, 1, GDT_Byte, nullptr));
  ASSERT_NE(file, nullptr);
  file.reset();
  file.reset(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
  ASSERT_NE(file, nullptr);
  int half = 2;
  ASSERT_EQ(file->BuildOverviews("AVERAGE", 1, &half, 0, nullptr, nullptr, nullptr), CE_None);
  file.reset(GDALDataset::Open((path + ".ovr").c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
  ASSERT_NE(file, nullptr);
  file->GetRasterBand(1)->Fill(9);
}

// Its mask, which shows nothing, in a file of its own.
void WriteMaskedDem(const std::string& path) {
  RegisterGdalDrivers();
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  GDALDatasetUniquePtr file(driver->Create(path.c_str(), 8, 8, 1, GDT_Float32, nullptr));
  ASSERT_NE(file, nullptr);
  OGRSpatialReference crs;
  crs.importFromEPSG(32635);
  file->SetSpatialRef(&crs);
  double transform[6] = {500000, 1, 0, 5200000, 0, -1};
  file->SetGeoTransform(transform);
  const CPLConfigOptionSetter outside("GDAL_TIFF_INTERNAL_MASK", "NO", false);
  ASSERT_EQ(file->CreateMaskBand(GMF_PER_DATASET), CE_None);
  file->GetRasterBand(1)->GetMaskBand()->Fill(0);
}

// What `read` expects holds, or the machine is said to have refused a.tif, with few files that may
// be opened.
template <typename Read>
void ExpectTrueOrRefused(const Read& read) {
  int refused = 0;
  for (rlim_t count = 0; count < 4; ++count) {
    SCOPED_TRACE(count);
    const FewFiles few(count);
    try {
      read();
    } catch (const EnvironmentError& error) {
      EXPECT_NE(std::string(error.what()).find("a.tif"), std::string::npos);
      ++refused;
    }
  }
  EXPECT_GT(refused, 1);
  EXPECT_LT(refused, 4);
}

TEST(GdalFaults, ARasterIsNotOpenedWithoutTheOverviewsThatItHas) {
  ORIENT_REQUIRE_FEW_FILES();
  const TemporaryFolder folder;
  WriteTiff(folder / "a.tif");
  ExpectTrueOrRefused([&] {
    const Raster raster = Raster::Open(folder / "a.tif");
    EXPECT_EQ(raster.ReadGrey({0, 0, 64, 64}, 2).image.At(5, 5), 9);
  });
}

TEST(GdalFaults, OverviewsThatCannotBeOpenedAreNotNone) {
  ORIENT_REQUIRE_FEW_FILES();
  const TemporaryFolder folder;
  WriteTiff(folder / "a.tif");
  ExpectTrueOrRefused([&] { EXPECT_EQ(CoarsestOverview(folder / "a.tif"), 2); });
}

// GDAL looks for a mask when it is asked for.
TEST(GdalFaults, AMaskThatCannotBeOpenedIsNotNone) {
  ORIENT_REQUIRE_FEW_FILES();
  const TemporaryFolder folder;
  WriteMaskedDem(folder / "a.tif");
  const DemRaster dem(folder / "a.tif");
  {
    const FewFiles none(0);
    EXPECT_THROW(dem.Read(0, 0, 8, 8), EnvironmentError);
  }
}

// GDAL takes tables that SQLite cannot read for absent, SQLite a failing device for a damaged file.
TEST(GdalFaults, WhatSqliteDoesNotReadIsTold) {
  RegisterGdalDrivers();
  sqlite3_vfs* files = sqlite3_vfs_find(nullptr);
  const auto read =
      reinterpret_cast<ssize_t (*)(int, void*, size_t)>(files->xGetSystemCall(files, "read"));
  ASSERT_NE(read, nullptr);
  const GdalFaults faults;
  char byte = 0;
  EXPECT_EQ(read(-1, &byte, 1), -1);  // no file of its own: not the machine's
  EXPECT_EQ(errno, EBADF);
  faults.ThrowIfAny();
  const int memory = open("/proc/self/mem", O_RDONLY);  // nothing is at its beginning
  ASSERT_GE(memory, 0);
  EXPECT_EQ(read(memory, &byte, 1), -1);
  EXPECT_EQ(errno, EIO);
  close(memory);
  EXPECT_THROW(faults.ThrowIfAny(), EnvironmentError);
}

TEST(GdalFaults, AFileThatIsAbsentOrAFolderIsNone) {
  const TemporaryFolder folder;
  const QuietGdal quiet;
  EXPECT_EQ(OpenRasterDataset(folder / "absent.tif"), nullptr);
  EXPECT_EQ(OpenRasterDataset(folder / ""), nullptr);
  quiet.ThrowFaults();
}

TEST(GdalFaults, WhatHadNoMemoryIsDoneOnceMore) {
  int tries = 0;
  const auto work = [&tries](int failures) {
    return [&tries, failures] {
      if (++tries <= failures) NoteGdalError(CPLE_AppDefined, "No space for tile buffer");
      return tries;
    };
  };
  EXPECT_EQ(Watched(work(0)), 1);
  tries = 0;
  EXPECT_EQ(Watched(work(1)), 2);
  tries = 0;
  EXPECT_EQ(Watched(work(9)), 2) << "there is memory: the file asks for too much";
}

TEST(GdalFaults, OfBeforeDoNotCount) {
  NoteGdalError(CPLE_OutOfMemory, "");
  const GdalFaults faults;
  EXPECT_FALSE(faults.OutOfMemory());
  faults.ThrowIfAny();
}

}  // namespace
}  // namespace orient
