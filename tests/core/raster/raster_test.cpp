#include "core/raster/raster.h"

#include <algorithm>
#include <filesystem>
#include <thread>

#include "core/base/error.h"
#include "core/raster/band_raster.h"
#include "core/raster/resample.h"
#include "tests/core/raster/gdal_writer.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kFloatRounding = 2e-4;  // grey values up to 1000 as float
constexpr double kX = 3.25, kY = -1.5, kAt0 = 500;

double Ramp(double x, double y) { return kAt0 + kX * x + kY * y; }

RasterRecipe RampRecipe() {
  RasterRecipe recipe;
  recipe.width = 84;
  recipe.height = 56;
  recipe.value = [](int, double x, double y) { return Ramp(x, y); };
  return recipe;
}

// Every pixel that is not NaN must be the ramp at its centre; at least `min_valid` are not NaN.
void ExpectRamp(const ImageWindow& window, size_t min_valid, double tolerance) {
  size_t valid = 0;
  for (int r = 0; r < window.image.height; ++r) {
    for (int c = 0; c < window.image.width; ++c) {
      if (std::isnan(window.image.At(c, r))) continue;
      const Eigen::Vector2d at = window.RasterFromImage({c + 0.5, r + 0.5});
      ASSERT_NEAR(window.image.At(c, r), Ramp(at.x(), at.y()), tolerance) << c << " " << r;
      ++valid;
    }
  }
  EXPECT_GE(valid, min_valid);
}

class RasterTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, const RasterRecipe& recipe) {
    WriteRaster(folder_ / name, recipe);
    return folder_ / name;
  }
  TemporaryFolder folder_;
};

TEST_F(RasterTest, StripedRampReadsExactly) {
  const Raster raster = Raster::Open(Write("a.tif", RampRecipe()));
  EXPECT_EQ(raster.Width(), 84);
  EXPECT_EQ(raster.Height(), 56);
  EXPECT_EQ(raster.Bands(), 1);
  EXPECT_EQ(raster.BitsPerSample(), 32);
  const ImageWindow all = raster.ReadGrey();
  EXPECT_EQ(all.image.width, 84);
  EXPECT_EQ(all.image.height, 56);
  ExpectRamp(all, 84 * 56, kFloatRounding);
  ExpectRamp(raster.ReadGrey({10, 20, 30, 7}), 30 * 7, kFloatRounding);
}

// Their rows are read past GDAL's blocks.
TEST_F(RasterTest, UncompressedRowsOfAllKinds) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_UInt16;
  // Nothing is written of rows that are zero, where the file may be sparse.
  recipe.value = [](int band, double x, double y) {
    return y < 20 || y > 40 ? 0 : 300 * band + std::floor(3 * x + 2 * y);
  };
  int file = 0;
  for (const int bands : {1, 3})
    for (const char* option : {"SPARSE_OK=FALSE", "SPARSE_OK=TRUE", "ENDIANNESS=BIG",
                               "BLOCKYSIZE=7", "INTERLEAVE=BAND", "TILED=YES"}) {
      recipe.bands = bands;
      recipe.options = {option};
      const std::string name = std::to_string(file++) + ".tif";
      const ImageWindow window = Raster::Open(Write(name, recipe)).ReadGrey({30, 10, 40, 40});
      for (int r = 0; r < 40; ++r)
        for (int c = 0; c < 40; ++c) {
          const double x = c + 30.5, y = r + 10.5;
          const auto in = [&](int band) { return recipe.value(band, x, y); };
          const double grey = bands == 1 ? in(1) : 0.299 * in(1) + 0.587 * in(2) + 0.114 * in(3);
          ASSERT_NEAR(window.image.At(c, r), grey, kFloatRounding)
              << option << " " << c << " " << r;
        }
    }
}

TEST_F(RasterTest, ReductionsKeepTheRampInTheCornerConvention) {
  RasterRecipe tiled = RampRecipe();
  tiled.options = {"TILED=YES", "BLOCKXSIZE=16", "BLOCKYSIZE=16", "COMPRESS=LZW"};
  const Raster raster = Raster::Open(Write("a.tif", tiled));
  for (const double reduction : {1.0, 2.0, 3.5, 2.75, 7.0}) {
    const ImageWindow all = raster.ReadGrey({0, 0, 84, 56}, reduction);
    EXPECT_EQ(all.image.width, std::ceil(84 / reduction)) << reduction;
    EXPECT_EQ(all.image.height, std::ceil(56 / reduction)) << reduction;
    const int full = static_cast<int>(84 / reduction) * static_cast<int>(56 / reduction);
    // The last column and row may hang over the raster's edge, whose missing part moves the mean.
    ImageWindow inner = all;
    for (int r = 0; r < inner.image.height; ++r)
      for (int c = 0; c < inner.image.width; ++c)
        if ((c + 1) * reduction > 84 + 1e-9 || (r + 1) * reduction > 56 + 1e-9)
          inner.image.At(c, r) = kNoData;
    ExpectRamp(inner, static_cast<size_t>(full), kFloatRounding);
    ExpectRamp(raster.ReadGrey({7, 5, 28, 28}, reduction), 16, kFloatRounding);
  }
}

TEST_F(RasterTest, OverviewsKeepTheRampToo) {
  RasterRecipe recipe = RampRecipe();
  recipe.width = 256;
  recipe.height = 192;
  recipe.value = [](int, double x, double y) { return Ramp(x, y); };
  recipe.overviews = {2, 4, 8};
  const Raster raster = Raster::Open(Write("a.tif", recipe));
  for (const double reduction : {1.0, 2.0, 3.5, 4.0, 8.0, 11.0}) {
    // Away from the edge: there GDAL's own overview has nothing beyond to average.
    ExpectRamp(raster.ReadGrey({16, 24, 176, 88}, reduction), 100, 1e-3);
  }
}

TEST_F(RasterTest, OverviewIsUsedWhereItIsFineEnough) {
  RasterRecipe recipe = RampRecipe();
  recipe.overviews = {2};
  const std::string path = Write("a.tif", recipe);
  {  // mark the overview, so that its use shows
    const GDALDatasetUniquePtr dataset(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_UPDATE));
    ASSERT_EQ(dataset->GetRasterBand(1)->GetOverview(0)->Fill(7), CE_None);
  }
  const Raster raster = Raster::Open(path);
  EXPECT_NE(raster.ReadGrey({0, 0, 28, 28}, 1.75).image.At(2, 2), 7);
  EXPECT_EQ(raster.ReadGrey({0, 0, 28, 28}, 2).image.At(2, 2), 7);
  EXPECT_EQ(raster.ReadGrey({0, 0, 28, 28}, 3.5).image.At(2, 2), 7);
}

TEST_F(RasterTest, SampledPositionsAgreeWithTheRamp) {
  const Raster raster = Raster::Open(Write("a.tif", RampRecipe()));
  const ImageWindow window = raster.ReadGrey({10, 6, 40, 40}, 2);
  const Eigen::Vector2d place(31.3, 22.9);
  EXPECT_NEAR(SampleBicubic(window.image, window.ImageFromRaster(place)),
              Ramp(place.x(), place.y()), kFloatRounding);
}

TEST_F(RasterTest, WindowReachingOutsideIsNanThere) {
  const Raster raster = Raster::Open(Write("a.tif", RampRecipe()));
  const ImageWindow window = raster.ReadGrey({-5, -3, 94, 62});
  EXPECT_EQ(window.image.width, 94);
  EXPECT_TRUE(std::isnan(window.image.At(4, 10)));
  EXPECT_FALSE(std::isnan(window.image.At(5, 3)));
  EXPECT_FALSE(std::isnan(window.image.At(88, 58)));
  EXPECT_TRUE(std::isnan(window.image.At(89, 58)));
  EXPECT_TRUE(std::isnan(window.image.At(88, 59)));
  ExpectRamp(window, 84 * 56, kFloatRounding);
  for (const PixelWindow& far : {PixelWindow{-50, 0, 20, 20}, PixelWindow{84, 56, 9, 9}})
    for (const float value : raster.ReadGrey(far, 2.5).image.values) EXPECT_TRUE(std::isnan(value));
}

TEST_F(RasterTest, ByteAndSixteenBitAndTwelveBit) {
  RasterRecipe recipe = RampRecipe();
  recipe.value = [](int, double x, double y) { return std::floor(x) + std::floor(y); };
  recipe.type = GDT_Byte;
  EXPECT_EQ(Raster::Open(Write("8.tif", recipe)).BitsPerSample(), 8);
  recipe.type = GDT_UInt16;
  recipe.value = [](int, double x, double y) { return 700 * std::floor(x) + std::floor(y); };
  const Raster raster = Raster::Open(Write("16.tif", recipe));
  EXPECT_EQ(raster.BitsPerSample(), 16);
  EXPECT_EQ(raster.ReadGrey().image.At(80, 5), 56005);
  recipe.options = {"NBITS=12"};
  recipe.value = [](int, double x, double) { return 40 * std::floor(x); };
  EXPECT_EQ(Raster::Open(Write("12.tif", recipe)).BitsPerSample(), 12);
}

TEST_F(RasterTest, ColoursBecomeGreyWithTheUsualWeights) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_Byte;
  recipe.bands = 3;
  recipe.options = {"PHOTOMETRIC=RGB"};
  recipe.value = [](int band, double, double) { return band == 1 ? 200 : band == 2 ? 100 : 50; };
  const Raster raster = Raster::Open(Write("rgb.tif", recipe));
  EXPECT_NEAR(raster.ReadGrey().image.At(3, 3), 0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1e-4);
}

TEST_F(RasterTest, AlphaZeroIsNoData) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_Byte;
  recipe.bands = 4;
  recipe.options = {"PHOTOMETRIC=RGB", "ALPHA=YES"};
  recipe.value = [](int band, double x, double) { return band < 4 ? 90 : x < 10 ? 0 : 255; };
  const Image image = Raster::Open(Write("rgba.tif", recipe)).ReadGrey().image;
  EXPECT_TRUE(std::isnan(image.At(9, 9)));
  EXPECT_NEAR(image.At(10, 9), 90, 1e-4);
}

TEST_F(RasterTest, InternalMaskIsNoData) {
  RasterRecipe recipe = RampRecipe();
  recipe.prepare = [](GDALDataset* dataset) {
    CPLSetConfigOption("GDAL_TIFF_INTERNAL_MASK", "YES");
    ASSERT_EQ(dataset->CreateMaskBand(GMF_PER_DATASET), CE_None);
    GDALRasterBand* mask = dataset->GetRasterBand(1)->GetMaskBand();
    std::vector<GByte> line(84, 255);
    std::fill_n(line.begin(), 20, GByte{0});
    for (int r = 0; r < 56; ++r)
      ASSERT_EQ(mask->RasterIO(GF_Write, 0, r, 84, 1, line.data(), 84, 1, GDT_Byte, 0, 0, nullptr),
                CE_None);
    CPLSetConfigOption("GDAL_TIFF_INTERNAL_MASK", nullptr);
  };
  const ImageWindow window = Raster::Open(Write("mask.tif", recipe)).ReadGrey();
  EXPECT_TRUE(std::isnan(window.image.At(19, 9)));
  ExpectRamp(window, 64 * 56, kFloatRounding);
}

TEST_F(RasterTest, NoDataOnlyWhereAllBandsHoldIt) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_Byte;
  recipe.bands = 3;
  recipe.options = {"PHOTOMETRIC=RGB"};
  recipe.prepare = [](GDALDataset* dataset) {
    for (int b = 1; b <= 3; ++b) dataset->GetRasterBand(b)->SetNoDataValue(0);
  };
  recipe.value = [](int band, double x, double) {
    return x < 10 ? 0 : x < 20 && band < 3 ? 0 : 80;
  };
  const Image image = Raster::Open(Write("nodata.tif", recipe)).ReadGrey().image;
  EXPECT_TRUE(std::isnan(image.At(5, 5)));
  EXPECT_NEAR(image.At(15, 5), 0.114 * 80, 1e-4);
  EXPECT_NEAR(image.At(25, 5), 80, 1e-4);
}

TEST_F(RasterTest, PaletteIsExpanded) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_Byte;
  recipe.overviews = {2};
  recipe.overview_method = "NEAREST";
  recipe.prepare = [](GDALDataset* dataset) {
    GDALColorTable table;
    const GDALColorEntry red{255, 0, 0, 255}, white{240, 240, 240, 255};
    table.SetColorEntry(0, &white);
    table.SetColorEntry(1, &red);
    dataset->GetRasterBand(1)->SetColorTable(&table);
  };
  recipe.value = [](int, double x, double) { return x < 10 ? 0 : 1; };
  const Raster raster = Raster::Open(Write("palette.tif", recipe));
  EXPECT_NEAR(raster.ReadGrey().image.At(9, 5), 240, 1e-4);
  EXPECT_NEAR(raster.ReadGrey().image.At(10, 5), 0.299 * 255, 1e-4);
  EXPECT_NEAR(raster.ReadGrey({9, 0, 2, 2}, 2).image.At(0, 0), (240 + 0.299 * 255) / 2, 1e-4);
}

TEST_F(RasterTest, BlackAndWhiteScansWithZeroForWhite) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_Byte;
  recipe.value = [](int, double x, double) { return x < 10 ? 0 : 255; };
  recipe.options = {"PHOTOMETRIC=MINISWHITE"};
  EXPECT_EQ(Raster::Open(Write("white8.tif", recipe)).ReadGrey().image.At(0, 0), 255);
  recipe.options = {"PHOTOMETRIC=MINISWHITE", "NBITS=1", "COMPRESS=CCITTFAX4"};
  recipe.value = [](int, double x, double) { return x < 10 ? 0 : 1; };
  const Raster raster = Raster::Open(Write("white1.tif", recipe));
  EXPECT_EQ(raster.BitsPerSample(), 1);
  EXPECT_EQ(raster.ReadGrey().image.At(0, 0), 255);
  EXPECT_EQ(raster.ReadGrey().image.At(20, 0), 0);
}

TEST_F(RasterTest, SixteenBitsWithZeroForWhiteKeepThemAll) {
  RasterRecipe recipe = RampRecipe();
  recipe.type = GDT_UInt16;
  recipe.options = {"PHOTOMETRIC=MINISWHITE"};
  recipe.value = [](int, double x, double) { return 4095 - 16 * x; };
  const std::string path = Write("white16.tif", recipe);
  const Image grey = Raster::Open(path).ReadGrey().image;
  EXPECT_EQ(grey.At(1, 0) - grey.At(0, 0), 16);
  EXPECT_EQ(grey.At(0, 0), 65535 - (4095 - 8));
  const Image band = BandRaster::Open(path).Read({0, 0, 20, 1}).front();
  EXPECT_EQ(band.At(0, 0), grey.At(0, 0)) << "no palette, and black is 0";
}

TEST_F(RasterTest, GeoreferenceAndResolutionTag) {
  RasterRecipe recipe = RampRecipe();
  recipe.prepare = [](GDALDataset* dataset) {
    std::array<double, 6> g = {5e5, 2, 0, 5e6, 0, -2};
    dataset->SetGeoTransform(g.data());
    OGRSpatialReference crs;
    ASSERT_EQ(crs.importFromEPSG(32635), OGRERR_NONE);
    dataset->SetSpatialRef(&crs);
    dataset->SetMetadataItem("TIFFTAG_XRESOLUTION", "400");
    dataset->SetMetadataItem("TIFFTAG_YRESOLUTION", "402");
    dataset->SetMetadataItem("TIFFTAG_RESOLUTIONUNIT", "3");
  };
  const Raster with = Raster::Open(Write("geo.tif", recipe));
  ASSERT_TRUE(with.GeoTransform().has_value());
  EXPECT_EQ((*with.GeoTransform())[5], -2);
  EXPECT_NE(with.CrsWkt().find("UTM zone 35N"), std::string::npos);
  EXPECT_NEAR(with.DpiTag().value_or(0), 401 * 2.54, 1e-3);
  const Raster without = Raster::Open(Write("plain.tif", RampRecipe()));
  EXPECT_FALSE(without.GeoTransform().has_value());
  EXPECT_EQ(without.CrsWkt(), "");
  EXPECT_FALSE(without.DpiTag().has_value());
}

TEST_F(RasterTest, VirtualPathsAndSideFiles) {
  const std::string path = Write("a.tif", RampRecipe());
  WriteRaster("/vsimem/orient-raster-test.tif", RampRecipe());
  ExpectRamp(Raster::Open("/vsimem/orient-raster-test.tif").ReadGrey(), 84 * 56, kFloatRounding);
  VSIUnlink("/vsimem/orient-raster-test.tif");
  const std::string beside = "/vsisubfile/0_100000," + path;
  ExpectRamp(Raster::Open(beside).ReadGrey({0, 0, 84, 56}, 2), 42 * 28, kFloatRounding);
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_.Path()))
    ++files;
  EXPECT_EQ(files, 1u) << "reading leaves nothing beside the raster";
}

TEST_F(RasterTest, EmptyWindowOrEnlargementIsTheCallersFault) {
  const Raster raster = Raster::Open(Write("a.tif", RampRecipe()));
  EXPECT_THROW(raster.ReadGrey({0, 0, 0, 5}), std::invalid_argument);
  EXPECT_THROW(raster.ReadGrey({0, 0, 5, 5}, 0.5), std::invalid_argument);
}

// Outside the image there is nothing to read, but memory is needed for it all the same.
TEST_F(RasterTest, AWindowOfMoreThanHalfAGigabyteIsRefused) {
  const Raster raster = Raster::Open(Write("ramp.tif", RampRecipe()));
  EXPECT_THROW(raster.ReadGrey({0, 0, 1 << 14, (1 << 13) + 1}), InputError);
  EXPECT_EQ(raster.ReadGrey({0, 0, 1 << 14, (1 << 13) + 1}, 1 << 10).image.width, 1 << 4);
}

TEST_F(RasterTest, ThreadsShareOneRaster) {
  RasterRecipe recipe = RampRecipe();
  recipe.options = {"COMPRESS=DEFLATE"};
  const Raster raster = Raster::Open(Write("a.tif", recipe));
  std::vector<std::thread> threads;
  std::vector<int> wrong(4, 0);
  for (size_t k = 0; k < wrong.size(); ++k)
    threads.emplace_back([&raster, &wrong, k] {
      for (int i = 0; i < 50; ++i) {
        const ImageWindow w = raster.ReadGrey({i % 20, i % 10, 30, 30}, 1 + i % 3);
        const Eigen::Vector2d at = w.RasterFromImage({4.5, 4.5});
        if (std::abs(w.image.At(4, 4) - Ramp(at.x(), at.y())) > kFloatRounding) ++wrong[k];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST_F(RasterTest, Jpeg2000ReducesWithoutAShift) {
  GDALAllRegister();
  if (GetGDALDriverManager()->GetDriverByName("JP2OpenJPEG") == nullptr)
    GTEST_SKIP() << "this GDAL has no JPEG 2000 driver";
  RasterRecipe recipe = RampRecipe();
  recipe.driver = "JP2OpenJPEG";
  recipe.type = GDT_UInt16;
  recipe.width = recipe.height = 1024;
  recipe.options = {"REVERSIBLE=YES", "QUALITY=100", "RESOLUTIONS=4"};
  recipe.value = [](int, double x, double y) { return 1000 + 16 * x + 8 * y; };
  const Raster raster = Raster::Open(Write("a.jp2", recipe));
  const ImageWindow half = raster.ReadGrey({100, 100, 400, 400}, 4);
  const Eigen::Vector2d at = half.RasterFromImage({50.5, 50.5});
  // In raster pixels: the value of one pixel's step in x is 16.
  EXPECT_NEAR((half.image.At(50, 50) - (1000 + 16 * at.x() + 8 * at.y())) / 24, 0, 0.1);
}

TEST(RealRaster, FilmJpegReadsUnresampledAtReductionOne) {
  ORIENT_REQUIRE_SHARED_DATA(path, "film/0bbe1004.jpg");
  const Raster raster = Raster::Open(path);
  ASSERT_EQ(raster.Width(), 2828);
  ASSERT_EQ(raster.Height(), 2978);
  GDALDatasetUniquePtr dataset(GDALDataset::Open(path.c_str()));
  std::vector<float> rgb(3 * 30 * 20);
  ASSERT_EQ(dataset->RasterIO(GF_Read, 2790, 2950, 30, 20, rgb.data(), 30, 20, GDT_Float32, 3,
                              nullptr, 0, 0, 0, nullptr),
            CE_None);
  const Image image = raster.ReadGrey({2790, 2950, 30, 20}).image;
  for (size_t k = 0; k < 600; ++k)
    ASSERT_NEAR(image.values[k], 0.299f * rgb[k] + 0.587f * rgb[600 + k] + 0.114f * rgb[1200 + k],
                1e-3);
}

TEST(RealRaster, FilmJpegOverviewsLieWhereTheFullImageDoes) {
  ORIENT_REQUIRE_SHARED_DATA(path, "film/0bbe1004.jpg");
  const Raster raster = Raster::Open(path);
  // Lower right corner, where a stretched overview would be off by most.
  const PixelWindow window{2304, 2400, 512, 512};
  const Image by_overview = raster.ReadGrey(window, 8).image;
  const Image truth = ReduceBy(raster.ReadGrey(window).image, 8);
  double error = 0, spread = 0;
  for (size_t k = 0; k < truth.values.size(); ++k) {
    error += std::pow(by_overview.values[k] - truth.values[k], 2);
    spread += std::pow(truth.values[k] - truth.values[0], 2);
  }
  EXPECT_LT(std::sqrt(error / spread), 0.05);
}

}  // namespace
}  // namespace orient
