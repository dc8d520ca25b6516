#include "ortho/orthophoto.h"

#include <gdal_priv.h>
#include <gdal_utils.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/raster/band_raster.h"
#include "core/raster/raster.h"
#include "ortho/rectifier.h"
#include "tests/support/expect_error.h"
#include "tests/support/hilly_view.h"
#include "tests/support/shared_data.h"

namespace orient::ortho {
namespace {
namespace fs = std::filesystem;

class OrthophotoOfHills : public ::testing::Test {
 protected:
  // The orthophoto of a photo of ground whose grey values are value(x, y).
  template <typename Value>
  OrthoShares Make(const std::string& name, const Value& value, bool wall = false) {
    WriteHills(folder_ / "dem.tif", crs_, wall);
    WriteScan(folder_ / (name + ".tif"), photo_.view, Hills(wall), value);
    photo_.name = name;
    photo_.scan = folder_ / (name + ".tif");
    path_ = folder_ / (name + ".ortho.tif");
    plan_ = PlanOrthophoto(photo_, options_);
    return MakeOrthophoto(photo_, options_, plan_, path_, nullptr);
  }

  // Differences of the orthophoto's values, where it has any, sorted.
  template <typename Value>
  std::vector<double> Differences(const Value& value) const {
    const BandRaster ortho = BandRaster::Open(path_);
    const PixelWindow all{0, 0, ortho.Width(), ortho.Height()};
    const Image image = ortho.Read(all).front();
    const std::vector<std::uint8_t> mask = ortho.ReadMask(all);
    std::vector<double> off;
    for (int row = 0, i = 0; row < all.height; ++row)
      for (int col = 0; col < all.width; ++col, ++i) {
        if (mask[static_cast<std::size_t>(i)] == 0) continue;
        const Eigen::Vector2d at = plan_.grid.GroundFromPixel(col + 0.5, row + 0.5);
        off.push_back(std::abs(image.At(col, row) - value(at.x(), at.y())));
      }
    EXPECT_GT(off.size(), 50000U);
    std::sort(off.begin(), off.end());
    return off;
  }

  TemporaryFolder folder_;
  Crs crs_ = Crs::Parse("EPSG:32635", "test");
  OrientedPhoto photo_{"hills", "", HillyView()};
  OrthoOptions options_{folder_ / "dem.tif", crs_, 3.5};
  OrthoPlan plan_;
  std::string path_;
};

// Ground coordinates as grey values: an orthophoto's values say where they come from.
constexpr double kPerMetre = 20;
double East(double x, double) { return kPerMetre * (x - 3500); }
double North(double, double y) { return kPerMetre * (y - 1500); }

TEST_F(OrthophotoOfHills, ShowsEveryPlaceWhereItIs) {
  const double pixel_m = photo_.view.GroundPixel(100);
  for (const auto& coordinate : {East, North}) {
    Make("hills", coordinate);
    const std::vector<double> off = Differences(coordinate);
    EXPECT_LT(off.back() / kPerMetre, 0.2 * pixel_m) << "of pixels of " << pixel_m << " m";
    EXPECT_LT(off[off.size() / 2] / kPerMetre, 0.03 * pixel_m);
  }
}

TEST_F(OrthophotoOfHills, AveragesWherePixelsAreLarger) {
  options_.gsd_m = 12;
  const double pixel_m = photo_.view.GroundPixel(100);
  const auto stripes = [&](double x, double) {
    return std::fmod(x, 2 * pixel_m) < pixel_m ? 0 : 20000;
  };
  Make("stripes", stripes);
  const Image image = BandRaster::Open(path_).Read({60, 60, 40, 40}).front();
  const auto [low, high] = std::minmax_element(image.values.begin(), image.values.end());
  EXPECT_GT(*low, 2000) << "stripes of one pixel blend";
  EXPECT_LT(*high, 18000);
}

TEST_F(OrthophotoOfHills, IsACloudOptimizedGeoTiffWithItsAccuracy) {
  photo_.covariance = Matrix6d::Identity() * 1e-8;
  photo_.covariance->topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * 0.04;
  options_.metadata["ORIENT_MADE_FROM"] = "x";
  Make("hills", East);
  const Raster ortho = Raster::Open(path_);
  EXPECT_EQ(ortho.BitsPerSample(), 16);
  EXPECT_TRUE(Crs::Parse(ortho.CrsWkt(), path_).SameAs(crs_));
  EXPECT_NEAR(ortho.GeoTransform().value()[1], 3.5, 1e-12);
  const BandRaster bands = BandRaster::Open(path_);
  EXPECT_EQ(bands.Metadata("ORIENT_PHOTO"), "hills");
  EXPECT_EQ(bands.Metadata("ORIENT_MADE_FROM"), "x");
  EXPECT_EQ(bands.Metadata(kWithHeights), "1");
  EXPECT_NEAR(std::stod(bands.Metadata("ORIENT_CE90_MEDIAN_M")), plan_.accuracy->median_m, 1e-3);
  EXPECT_NE(ReadFile(path_).substr(0, 400).find("LAYOUT=IFDS_BEFORE_DATA"), std::string::npos);
}

TEST_F(OrthophotoOfHills, GroundBehindAWallHasNoDataAndIsMarked) {
  const OrthoShares shares = Make("wall", East, true);
  EXPECT_LT(shares.hidden, 0.1);
  // What is shown is where it is, but along the wall's edge, across which is interpolated. What is
  // hidden would be off by as much as the shadow is long.
  const std::vector<double> off = Differences(East);
  const auto beyond = off.end() - std::upper_bound(off.begin(), off.end(),
                                                   0.2 * kPerMetre * photo_.view.GroundPixel(100));
  EXPECT_LT(static_cast<double>(beyond), 0.007 * static_cast<double>(off.size()));
  EXPECT_GT(shares.hidden, 0.006);
  EXPECT_EQ(BandRaster::Open(path_).Metadata(kHasHidden), "yes");
  const BandRaster hidden = BandRaster::Open(HiddenPath(path_));
  const PixelWindow all{0, 0, hidden.Width(), hidden.Height()};
  const std::vector<float> marked = hidden.Read(all).front().values;
  const std::vector<std::uint8_t> seen = BandRaster::Open(path_).ReadMask(all);
  double count = 0;
  for (std::size_t i = 0; i < marked.size(); ++i) {
    count += marked[i];
    EXPECT_FALSE(marked[i] == 1 && seen[i] != 0);
  }
  EXPECT_NEAR(count / static_cast<double>(marked.size()), shares.hidden, 1e-9);
  Make("wall", East, false);
  EXPECT_FALSE(fs::exists(HiddenPath(path_))) << "of an earlier run";
  EXPECT_EQ(BandRaster::Open(path_).Metadata(kHasHidden), "no");
}

TEST_F(OrthophotoOfHills, ANegativeBecomesAPositive) {
  photo_.negative = true;
  Make("negative", [](double x, double y) { return 65535 - East(x, y); });
  EXPECT_LT(Differences(East).back() / kPerMetre, 0.2 * photo_.view.GroundPixel(100));
}

TEST_F(OrthophotoOfHills, ANegativeOfSignedValuesIsRefused) {
  Make("hills", East);
  const std::string path = folder_ / "signed.tif";
  {
    const GDALDatasetUniquePtr scan(GDALDataset::Open(photo_.scan.c_str()));
    const char* const options[] = {"-ot", "Int16", nullptr};
    GDALTranslateOptions* translate = GDALTranslateOptionsNew(const_cast<char**>(options), nullptr);
    GDALClose(GDALTranslate(path.c_str(), scan.get(), translate, nullptr));
    GDALTranslateOptionsFree(translate);
  }
  photo_.scan = path;
  photo_.negative = true;
  ExpectError<InputError>([&] { MakeOrthophoto(photo_, options_, plan_, path_, nullptr); },
                          {"signed.tif", "-ot UInt16"});
}

TEST_F(OrthophotoOfHills, IsTheSameForAnyNumberOfThreads) {
  options_.threads = 1;
  Make("hills", East, true);
  const std::string one = ReadFile(path_), hidden = ReadFile(HiddenPath(path_));
  options_.threads = 2;
  Make("hills", East, true);
  EXPECT_EQ(ReadFile(path_), one);
  EXPECT_EQ(ReadFile(HiddenPath(path_)), hidden);
}

TEST_F(OrthophotoOfHills, WhatCannotBeMadeIsRefusedByName) {
  Make("hills", East);
  OrientedPhoto far = photo_;
  far.view.pose.position_m.x() += 1e5;
  ExpectError<InputError>([&] { PlanOrthophoto(far, options_); }, {"dem.tif", "covers"});
  OrthoOptions tiny = options_;
  tiny.gsd_m = 1e-4;
  ExpectError<InputError>([&] { PlanOrthophoto(photo_, tiny); },
                          {"hills.tif", "larger pixel size"});
  OrientedPhoto gone = photo_;
  gone.scan = folder_ / "gone.tif";
  ExpectError<InputError>([&] { MakeOrthophoto(gone, options_, plan_, path_, nullptr); },
                          {"gone.tif"});
  const std::string nowhere = folder_ / "no/folder.tif";
  ExpectError<InputError>([&] { MakeOrthophoto(photo_, options_, plan_, nowhere, nullptr); },
                          {"no/folder.tif"});
}

TEST_F(OrthophotoOfHills, ADamagedScanLeavesNoFile) {
  Make("hills", East);
  const std::string contents = ReadFile(photo_.scan);
  WriteFileAtomically(photo_.scan, contents.substr(0, contents.size() / 2));
  fs::remove(path_);
  ExpectError<InputError>([&] { MakeOrthophoto(photo_, options_, plan_, path_, nullptr); },
                          {"hills.tif"});
  EXPECT_FALSE(fs::exists(path_));
  int others = 0;
  for (const auto& entry : fs::directory_iterator(folder_.Path()))
    others += entry.path().extension() == ".part" ? 1 : 0;
  EXPECT_EQ(others, 0);
}

}  // namespace
}  // namespace orient::ortho
