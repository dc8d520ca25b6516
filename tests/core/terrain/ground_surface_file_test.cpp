// Ground surfaces from DEM files.
#include <cpl_conv.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <gtest/gtest.h>
#include <ogr_spatialref.h>

#include <cmath>
#include <fstream>
#include <random>
#include <thread>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "core/terrain/ground_surface.h"
#include "tests/core/terrain/rough_ground.h"
#include "tests/support/dem_files.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

std::string Refusal(const std::string& path, const std::optional<Bounds>& bounds = std::nullopt) {
  try {
    GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"), bounds);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

DemFile SmallDem() {
  DemFile dem;
  dem.heights.resize(40, 60);
  for (int r = 0; r < 40; ++r)
    for (int c = 0; c < 60; ++c) dem.heights(r, c) = static_cast<float>(r * 100 + c);
  dem.west = 500000;
  dem.north = 5000000;
  dem.cell_x = dem.cell_y = 10;
  return dem;
}

TEST(GroundSurfaceFile, NodesLieInTheCellsCentres) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.heights(20, 20) = kNone;
  const auto path = WriteDem(folder / "dem", dem);
  const auto surface = GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"));
  EXPECT_NEAR(surface.HeightAt(500005, 4999995).value(), 0, 1e-6);
  EXPECT_NEAR(surface.HeightAt(500035, 4999975).value(), 203, 1e-6);
  EXPECT_FALSE(surface.HeightAt(500205, 4999795));  // nodata
  EXPECT_NEAR(surface.MaxHeight(), 3959, 1e-6);
}

TEST(GroundSurfaceFile, HeightsThatNoGroundHasAreVoids) {
  for (const float undeclared : {-32768.F, -9998.F, 3.4e38F, 65535.F}) {
    const TemporaryFolder folder;
    DemFile dem = SmallDem();
    dem.heights(20, 20) = undeclared;
    const auto path = WriteDem(folder / "dem", dem);
    const auto surface = GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"));
    EXPECT_FALSE(surface.HeightAt(500205, 4999795)) << undeclared;
    EXPECT_NEAR(surface.HeightAt(500235, 4999795).value(), 2023, 1e-6);
    EXPECT_NEAR(surface.MaxHeight(), 3959, 1e-6);
  }
}

TEST(GroundSurfaceFile, ReadsOnlyAWindowAroundTheBounds) {
  const TemporaryFolder folder;
  const auto path = WriteDem(folder / "dem", SmallDem());
  const Bounds bounds = {500200, 4999800, 500250, 4999850};
  const auto surface = GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"), bounds);
  EXPECT_NEAR(surface.HeightAt(500205, 4999805).value(), 1920, 1e-6);
  EXPECT_NEAR(surface.HeightAt(bounds.min_x, bounds.min_y).value(), 1969.5, 1e-6);
  EXPECT_TRUE(surface.HeightAt(bounds.max_x, bounds.max_y));
  EXPECT_LT(surface.Extent().max_x - surface.Extent().min_x, 130);
  // Bounds that stick out are cut.
  const auto corner = GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"),
                                              Bounds{499000, 4999950, 500030, 5009000});
  EXPECT_NEAR(corner.HeightAt(500005, 4999995).value(), 0, 1e-6);
}

TEST(GroundSurfaceFile, ACompoundCrsCountsHorizontally) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.srs = "EPSG:32635+5773";
  const auto surface =
      GroundSurface::FromFile(WriteDem(folder / "dem", dem), Crs::Parse("EPSG:32635", "test"));
  EXPECT_NEAR(surface.HeightAt(500035, 4999975).value(), 203, 1e-6);
}

// A DEM whose heights are its own column (or row) tells where the surface believes a point to be.
void ExpectExactPlaces(DemFile dem, const std::string& block_crs, double cell_m) {
  const TemporaryFolder folder;
  const Crs block = Crs::Parse(block_crs, "test");
  for (const bool by_column : {true, false}) {
    for (int r = 0; r < dem.heights.rows(); ++r)
      for (int c = 0; c < dem.heights.cols(); ++c)
        dem.heights(r, c) = static_cast<float>(by_column ? c : r);
    const auto surface = GroundSurface::FromFile(WriteDem(folder / "dem", dem), block);
    EXPECT_NEAR(surface.CellSize(), cell_m, 0.15 * cell_m);
    const auto dem_from_block = CoordinateTransform::Between(dem.srs, block.Wkt());
    const Bounds extent = surface.Extent();
    std::mt19937 random(TestSeed());
    std::uniform_real_distribution<double> x(extent.min_x, extent.max_x);
    std::uniform_real_distribution<double> y(extent.min_y, extent.max_y);
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector2d place(x(random), y(random));
      const Eigen::Vector2d in_dem = dem_from_block(place).value();
      const double column = (in_dem.x() - dem.west) / dem.cell_x - 0.5;
      const double row = (dem.north - in_dem.y()) / dem.cell_y - 0.5;
      const bool has_height = column >= 0 && row >= 0 &&
                              column <= static_cast<double>(dem.heights.cols() - 1) &&
                              row <= static_cast<double>(dem.heights.rows() - 1);
      const auto height = surface.HeightAt(place.x(), place.y());
      ASSERT_EQ(height.has_value(), has_height);
      if (!height) continue;
      ++inside;
      EXPECT_NEAR(*height, by_column ? column : row, 1e-3 / cell_m);  // a millimetre
    }
    EXPECT_GT(inside, 1000);
  }
}

TEST(GroundSurfaceFile, ADemOfTheNeighbouringZoneIsExactToAMillimetre) {
  DemFile dem;
  dem.srs = "EPSG:32636";
  dem.heights.resize(400, 500);
  dem.west = 200000;
  dem.north = 5000000;
  dem.cell_x = dem.cell_y = 100;  // 50 x 40 km
  ExpectExactPlaces(dem, "EPSG:32635", 100);
}

TEST(GroundSurfaceFile, ADemOfAWholeCountryIsExactToAMillimetre) {
  DemFile dem;
  dem.srs = "EPSG:32636";
  dem.heights.resize(400, 400);
  dem.west = 100000;
  dem.north = 6000000;
  dem.cell_x = dem.cell_y = 2000;  // 800 x 800 km
  ExpectExactPlaces(dem, "EPSG:32635", 2000);
}

TEST(GroundSurfaceFile, AGeographicDemIsExactToAMillimetre) {
  DemFile dem;
  dem.srs = "EPSG:4326";
  dem.heights.resize(720, 720);
  dem.west = 26.5;
  dem.north = 60.5;
  dem.cell_x = dem.cell_y = 1.0 / 1200;  // three arc seconds, 33 x 67 km
  ExpectExactPlaces(dem, "EPSG:32635", 66);
}

TEST(GroundSurfaceFile, RaysMeetADemInAnotherCrsWhereItsHeightsAre) {
  const TemporaryFolder folder;
  std::mt19937 random(TestSeed());
  DemFile dem;
  dem.srs = "EPSG:4326";
  dem.heights = RoughGround(400, 400, 0, &random);
  dem.west = 26.9;
  dem.north = 60.1;
  dem.cell_x = dem.cell_y = 1.0 / 3600;
  const auto surface =
      GroundSurface::FromFile(WriteDem(folder / "dem", dem), Crs::Parse("EPSG:32635", "test"));
  const Bounds extent = surface.Extent();
  std::uniform_real_distribution<double> x(extent.min_x + 1500, extent.max_x - 1500);
  std::uniform_real_distribution<double> y(extent.min_y + 1500, extent.max_y - 1500);
  int checked = 0;
  for (int i = 0; i < 1000; ++i) {
    // Rays as flat as 10 degrees: they cross many pieces of the curved mapping.
    const Ray ray = From({x(random), y(random), 900}, {x(random), y(random), 100});
    const auto hit = surface.Intersect(ray);
    if (!hit) continue;
    ++checked;
    const Eigen::Vector3d offset = *hit - ray.origin_m;
    EXPECT_LT((offset - offset.dot(ray.direction) * ray.direction).norm(), 1e-6);
    // Rough ground rises by up to 8 m per metre; the mapping is exact to 0.1 mm.
    EXPECT_NEAR(surface.HeightAt(hit->x(), hit->y()).value(), hit->z(), 1e-3);
  }
  EXPECT_GT(checked, 900);
}

TEST(GroundSurfaceFile, SeveralThreadsSeeOneSurface) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.srs = "EPSG:32636";
  dem.west = 200000;
  const auto surface =
      GroundSurface::FromFile(WriteDem(folder / "dem", dem), Crs::Parse("EPSG:32635", "test"));
  const Bounds extent = surface.Extent();
  const auto sum = [&] {
    double total = 0;
    for (int i = 1; i < 20000; ++i)
      total += surface
                   .HeightAt(extent.min_x + i * 1e-4 * (extent.max_x - extent.min_x) / 2,
                             0.5 * (extent.min_y + extent.max_y))
                   .value_or(0);
    return total;
  };
  const double expected = sum();
  std::vector<double> sums(4);
  std::vector<std::thread> threads;
  for (double& result : sums) threads.emplace_back([&] { result = sum(); });
  for (std::thread& thread : threads) thread.join();
  for (const double result : sums) EXPECT_EQ(result, expected);
}

TEST(GroundSurfaceFile, WhatIsWrongWithADemIsSaidWithItsName) {
  const TemporaryFolder folder;
  const auto expect = [](const std::string& message, const std::string& path,
                         const std::string& part) {
    EXPECT_NE(message.find(path), std::string::npos) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_NE(message.find(';'), std::string::npos) << "no remedy: " << message;
  };
  expect(Refusal(folder / "none.tif"), "none.tif", "cannot be opened");
  DemFile dem = SmallDem();
  const auto good = WriteDem(folder / "good", dem);
  expect(Refusal(good, Bounds{100000, 100000, 100100, 100100}), "good.vrt", "100100");
  expect(Refusal(good, Bounds{4999700, 500100, 4999900, 500300}), "good.vrt", "x and y exchanged");
  // Bounds in another place of the world, where the DEM's CRS may not even be defined.
  expect(Refusal(good, Bounds{9e9, 9e9, 1e10, 1e10}), "good.vrt", "covers");
  dem.georeferenced = false;
  expect(Refusal(WriteDem(folder / "unplaced", dem)), "unplaced.vrt", "no georeference");
  dem = SmallDem();
  dem.srs = "";
  expect(Refusal(WriteDem(folder / "crsless", dem)), "crsless.vrt", "no CRS");
  dem = SmallDem();
  dem.unit = "ft";
  expect(Refusal(WriteDem(folder / "feet", dem)), "feet.vrt", "'ft'");
  std::string coloured = ReadFile(good);
  coloured.replace(coloured.find("<NoDataValue>"), 0, "<ColorInterp>Red</ColorInterp>");
  WriteFileAtomically(folder / "map.vrt", coloured);
  expect(Refusal(folder / "map.vrt"), "map.vrt", "picture in colours");
  dem = SmallDem();
  dem.heights.setConstant(kNone);
  expect(Refusal(WriteDem(folder / "hole", dem)), "hole.vrt", "only nodata");
}

TEST(GroundSurfaceFile, OnlyMetresAreHeights) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  for (const char* metres : {"", "m", "Metre", "metres", "METERS", " m "}) {
    dem.unit = metres;
    EXPECT_EQ(Refusal(WriteDem(folder / "metres", dem)), "") << metres;
  }
  for (const char* other : {"Feet", "ftUS", "[ft_i]", "cm", "km", "fathom", "unknown"}) {
    dem.unit = other;
    const std::string message = Refusal(WriteDem(folder / "other", dem));
    EXPECT_NE(message.find("'" + std::string(other) + "', not in metres"), std::string::npos)
        << message;
  }
}

TEST(GroundSurfaceFile, ACrsOfFeetOrDepthsIsRefused) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.unit = "";
  dem.srs = "EPSG:32635+6360";  // NAVD88 in US survey feet
  EXPECT_NE(Refusal(WriteDem(folder / "feet", dem)).find("not in metres"), std::string::npos);
  dem.srs = "EPSG:32635+5715";  // depth below mean sea level
  EXPECT_NE(Refusal(WriteDem(folder / "depths", dem)).find("counts depths"), std::string::npos);
}

std::string WithEllipsoidalHeights(const std::string& definition, const std::string& unit,
                                   double metres) {
  OGRSpatialReference crs;
  EXPECT_EQ(crs.SetFromUserInput(definition.c_str()), OGRERR_NONE);
  EXPECT_EQ(crs.PromoteTo3D(nullptr), OGRERR_NONE);
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* text = nullptr;
  EXPECT_EQ(crs.exportToWkt(&text, options), OGRERR_NONE);
  std::string wkt(text);
  CPLFree(text);
  const std::string axis = "height (h)\",up,ORDER[3],LENGTHUNIT[", metre = "\"metre\",1";
  wkt.replace(wkt.find(axis) + axis.size(), metre.size(), fmt::format("\"{}\",{}", unit, metres));
  return wkt;
}

TEST(GroundSurfaceFile, HeightsAboveTheEllipsoidAreInMetresToo) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.unit = "";
  const Crs block = Crs::Parse(dem.srs, "test");
  dem.srs = WithEllipsoidalHeights(dem.srs, "metre", 1);
  EXPECT_EQ(Refusal(WriteDem(folder / "metres", dem)), "");
  EXPECT_TRUE(block.SameAs(Crs::Parse(dem.srs, "test")));
  dem.srs = WithEllipsoidalHeights(dem.srs, "foot", 0.3048);
  EXPECT_NE(Refusal(WriteDem(folder / "feet", dem)).find("'foot', not in metres"),
            std::string::npos);
}

TEST(GroundSurfaceFile, AScaleThatGivesNoHeightsIsRefused) {
  const TemporaryFolder folder;
  const std::string text = ReadFile(WriteDem(folder / "dem", SmallDem()));
  for (const char* wrong : {"<Scale>0</Scale>", "<Scale>nan</Scale>", "<Offset>inf</Offset>"}) {
    std::string vrt = text;
    vrt.replace(vrt.find("<NoDataValue>"), 0, wrong);
    WriteFileAtomically(folder / "wrong.vrt", vrt);
    EXPECT_NE(Refusal(folder / "wrong.vrt").find("its values give no heights"), std::string::npos)
        << wrong;
  }
}

TEST(GroundSurfaceFile, LongitudesMayBeCountedTo360) {
  const TemporaryFolder folder;
  DemFile dem = SmallDem();
  dem.srs = "EPSG:4326";
  dem.cell_x = dem.cell_y = 0.001;
  dem.north = 47;
  const Crs utm17 = Crs::Parse("EPSG:32617", "test");  // its central meridian is 81 degrees west
  const Bounds bounds = {499000, 5203000, 500500, 5204000};
  dem.west = -81.03;
  const auto to_180 = GroundSurface::FromFile(WriteDem(folder / "to_180", dem), utm17, bounds);
  dem.west = 278.97;
  const auto to_360 = GroundSurface::FromFile(WriteDem(folder / "to_360", dem), utm17, bounds);
  for (const double x : {499100, 500000, 500400})
    EXPECT_NEAR(to_360.HeightAt(x, 5203500).value(), to_180.HeightAt(x, 5203500).value(), 1e-3);
}

TEST(GroundSurfaceFile, ARealDemOfTheNgiFrames) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "ngi");
  const Crs crs = Crs::FromFile(folder + "/published_orientation.prj");
  const auto surface = GroundSurface::FromFile(folder + "/dem.tif", crs);
  EXPECT_GT(surface.MinHeight(), 100);
  EXPECT_LT(surface.MaxHeight(), 900);
  EXPECT_NEAR(surface.CellSize(), 24, 1);
}

// A small grid blown up to 5000 x 5000 nodes: more than are held in memory at a time.
TEST(GroundSurface, OfALargeFileIsThatOfItsParts) {
  const TemporaryFolder folder;
  std::mt19937 random(TestSeed());
  DemFile small;
  small.heights = RoughGround(50, 50, 0, &random);
  WriteDem(folder / "small", small);
  std::ofstream vrt(folder / "large.vrt");
  vrt << "<VRTDataset rasterXSize=\"5000\" rasterYSize=\"5000\"><SRS>EPSG:32635</SRS>"
      << "<GeoTransform>500000, 1, 0, 5005000, 0, -1</GeoTransform>"
      << "<VRTRasterBand dataType=\"Float32\" band=\"1\"><SimpleSource><SourceFilename>"
      << folder / "small.asc"
      << "</SourceFilename><SourceBand>1</SourceBand>"
      << "<SrcRect xOff=\"0\" yOff=\"0\" xSize=\"50\" ySize=\"50\"/>"
      << "<DstRect xOff=\"0\" yOff=\"0\" xSize=\"5000\" ySize=\"5000\"/></SimpleSource>"
      << "</VRTRasterBand></VRTDataset>";
  vrt.close();
  const Crs crs = Crs::Parse("EPSG:32635", "test");
  const GroundSurface large = GroundSurface::FromFile(folder / "large.vrt", crs);
  EXPECT_NEAR(large.MinHeight(), small.heights.minCoeff(), 1e-4);
  EXPECT_NEAR(large.MaxHeight(), small.heights.maxCoeff(), 1e-4);
  for (const double west : {500500.0, 503900.0}) {
    const Bounds bounds{west, 5002000, west + 400, 5002400};
    const GroundSurface part = GroundSurface::FromFile(folder / "large.vrt", crs, bounds);
    std::uniform_real_distribution<double> inside(0, 400);
    for (int i = 0; i < 500; ++i) {
      const double x = west + inside(random), y = 5002000 + inside(random);
      EXPECT_EQ(large.HeightAt(x, y), part.HeightAt(x, y));
      const Ray ray = From({x, y, 1000}, {west + 200, 5002200, 0});
      const auto hit = large.Intersect(ray);
      ASSERT_TRUE(hit);
      EXPECT_LT((*hit - *part.Intersect(ray)).norm(), 1e-6);
    }
  }
}

TEST(GroundSurfaceFile, WhereAMaskHidesTheHeightsThereIsNoGround) {
  const TemporaryFolder folder;
  const std::string path = folder / "masked.tif";
  RegisterGdalDrivers();
  {
    const CPLConfigOptionSetter inside("GDAL_TIFF_INTERNAL_MASK", "YES", false);
    GDALDatasetUniquePtr file(GetGDALDriverManager()->GetDriverByName("GTiff")->Create(
        path.c_str(), 20, 10, 1, GDT_Float32, nullptr));
    double place[6] = {500000, 10, 0, 5000000, 0, -10};
    file->SetGeoTransform(place);
    OGRSpatialReference reference;
    reference.importFromEPSG(32635);
    file->SetSpatialRef(&reference);
    std::vector<float> heights(200, 300);
    std::vector<std::uint8_t> mask(200, 255);
    for (int row = 0; row < 10; ++row)
      for (int col = 12; col < 20; ++col) {
        heights[static_cast<std::size_t>(20 * row + col)] = 0;
        mask[static_cast<std::size_t>(20 * row + col)] = 0;
      }
    ASSERT_EQ(file->GetRasterBand(1)->RasterIO(GF_Write, 0, 0, 20, 10, heights.data(), 20, 10,
                                               GDT_Float32, 0, 0),
              CE_None);
    ASSERT_EQ(file->CreateMaskBand(GMF_PER_DATASET), CE_None);
    ASSERT_EQ(file->GetRasterBand(1)->GetMaskBand()->RasterIO(GF_Write, 0, 0, 20, 10, mask.data(),
                                                              20, 10, GDT_Byte, 0, 0),
              CE_None);
  }
  const GroundSurface surface = GroundSurface::FromFile(path, Crs::Parse("EPSG:32635", "test"));
  EXPECT_EQ(surface.HeightAt(500055, 4999945), 300);
  EXPECT_FALSE(surface.HeightAt(500155, 4999945));
}

}  // namespace
}  // namespace orient
