#include "core/terrain/ground_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>
#include <random>
#include <thread>

#include "core/base/error.h"
#include "tests/core/terrain/dem_files.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kClosedForm = 1e-9;
constexpr double kOnSurface_m = 1e-4;  // what the header promises
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

Ray From(const Eigen::Vector3d& origin, const Eigen::Vector3d& to) {
  return {origin, (to - origin).normalized()};
}

// Hills, steps and holes: nothing that a smooth approximation could follow.
Eigen::MatrixXf RoughGround(int rows, int columns, double holes, std::mt19937* random) {
  std::uniform_real_distribution<float> any(0, 1);
  Eigen::MatrixXf heights(rows, columns);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      heights(r, c) = 100 + 40 * std::sin(0.3f * static_cast<float>(r)) +
                      30 * std::cos(0.2f * static_cast<float>(c)) + 15 * any(*random);
      if (any(*random) < 0.1f) heights(r, c) += 60;
      if (any(*random) < static_cast<float>(holes)) heights(r, c) = kNone;
    }
  return heights;
}

TEST(GroundSurface, IsBilinearBetweenCellCentres) {
  Eigen::MatrixXf heights(2, 2);
  heights << 10, 20, 30, 60;
  const GroundSurface surface = GroundSurface::FromGrid(heights, 100, 200, 2);
  EXPECT_NEAR(surface.HeightAt(101, 199).value(), 10, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(103, 199).value(), 20, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(101, 197).value(), 30, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(103, 197).value(), 60, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(102, 198).value(), 30, kClosedForm);
  EXPECT_NEAR(surface.HeightAt(101.5, 198.5).value(), 10 + 2.5 + 5 + 20 / 16.0, kClosedForm);
  EXPECT_EQ(surface.MinHeight(), 10);
  EXPECT_EQ(surface.MaxHeight(), 60);
  EXPECT_EQ(surface.MeanHeight(), 30);
  EXPECT_EQ(surface.CellSize(), 2);
  EXPECT_EQ(surface.Extent().min_x, 101);
  EXPECT_EQ(surface.Extent().max_y, 199);
}

TEST(GroundSurface, HasNoHeightBeyondItsOutermostNodesOrBesideNodata) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(4, 4, 5.f);
  heights(1, 1) = kNone;
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 4, 1);
  EXPECT_TRUE(surface.HeightAt(3.2, 1.2));
  EXPECT_FALSE(surface.HeightAt(0.49, 1.2));
  EXPECT_FALSE(surface.HeightAt(3.51, 1.2));
  EXPECT_FALSE(surface.HeightAt(2, 3.51));
  EXPECT_FALSE(surface.HeightAt(2, 0.49));
  EXPECT_FALSE(surface.HeightAt(1.9, 2.9));
  EXPECT_FALSE(surface.HeightAt(std::nan(""), 2));
  EXPECT_FALSE(surface.HeightAt(1e30, -1e30));
}

TEST(GroundSurface, FewerThanTwoNodesOrNoCellSizeIsABrokenPromise) {
  EXPECT_THROW(GroundSurface::FromGrid(Eigen::MatrixXf::Zero(1, 5), 0, 0, 1),
               std::invalid_argument);
  EXPECT_THROW(GroundSurface::FromGrid(Eigen::MatrixXf::Zero(5, 5), 0, 0, 0),
               std::invalid_argument);
}

TEST(GroundSurface, APlumbLineHitsTheHeightBelow) {
  std::mt19937 random(TestSeed());
  const GroundSurface surface =
      GroundSurface::FromGrid(RoughGround(20, 20, 0, &random), 500000, 5000000, 5);
  for (const double x : {500002.5, 500010.0, 500033.3, 500097.5}) {
    const auto hit = surface.Intersect({{x, 4999950, 4000}, {0, 0, -1}});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->z(), surface.HeightAt(x, 4999950).value(), kClosedForm);
  }
}

// The slow and obvious way: march in steps of a hundredth of a cell and look for the first change
// from above to below, with no hole in between.
std::optional<Eigen::Vector3d> March(const GroundSurface& surface, const Ray& ray) {
  const double step = surface.CellSize() / 100;
  bool above = false;
  const double begin = (surface.MaxHeight() + 0.5 - ray.origin_m.z()) / ray.direction.z();
  const double end = (surface.MinHeight() - 0.5 - ray.origin_m.z()) / ray.direction.z();
  for (double t = begin; t < end; t += step) {
    const Eigen::Vector3d p = ray.origin_m + t * ray.direction;
    const auto height = surface.HeightAt(p.x(), p.y());
    if (height && p.z() <= *height) return above ? std::optional(p) : std::nullopt;
    above = height.has_value();
  }
  return std::nullopt;
}

TEST(GroundSurface, TheFirstHitIsTheOneOfTheSlowAndObviousWay) {
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<double> any(0, 1);
  int hits = 0;
  for (const double holes : {0.0, 0.03}) {
    const GroundSurface surface =
        GroundSurface::FromGrid(RoughGround(30, 40, holes, &random), 1000, 2000, 10);
    for (int i = 0; i < 400; ++i) {
      const Eigen::Vector3d origin(1000 + 400 * any(random), 1700 + 300 * any(random), 700);
      const Eigen::Vector3d to(1000 + 400 * any(random), 1700 + 300 * any(random), 100);
      const Ray ray = From(origin, to);
      const auto hit = surface.Intersect(ray);
      const auto marched = March(surface, ray);
      // A ray that grazes a crest within a marching step can only be told apart by the exact way.
      if (hit && !marched && holes > 0) continue;
      ASSERT_EQ(hit.has_value(), marched.has_value()) << "ray " << i;
      if (!hit) continue;
      ++hits;
      EXPECT_NEAR(surface.HeightAt(hit->x(), hit->y()).value_or(0), hit->z(), kOnSurface_m);
      const double missed = (*marched - *hit).norm();
      if (missed > 0.2) {  // more than two steps: then the hit lies before, and is a real one
        EXPECT_LT(hit->z(), marched->z() + 40);
        EXPECT_GT((*marched - origin).norm(), (*hit - origin).norm());
      }
    }
  }
  EXPECT_GT(hits, 400);
}

TEST(GroundSurface, ACliffIsHitOnItsFaceAndHidesWhatLiesBehind) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Zero(10, 10);
  heights.rightCols(5).setConstant(200);  // rises within one cell, between x = 4.5 and 5.5
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  const auto face = surface.Intersect(From({-100, 5, 210}, {7, 5, 100}));
  ASSERT_TRUE(face);
  EXPECT_GT(face->x(), 4.5);
  EXPECT_LT(face->x(), 5.5);
  EXPECT_NEAR(face->z(), surface.HeightAt(face->x(), 5).value(), kOnSurface_m);
  // From the other side the plateau's edge hides the foot.
  const auto top = surface.Intersect(From({109, 5, 300}, {4, 5, 100}));
  EXPECT_FALSE(top);  // enters the DEM below the plateau: what hides it lies outside
  const auto plateau = surface.Intersect(From({9, 5, 230}, {6, 5, 195}));
  ASSERT_TRUE(plateau);
  EXPECT_NEAR(plateau->z(), 200, kOnSurface_m);
}

TEST(GroundSurface, AGrazingRayFindsTheCrestOrPassesOverIt) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Zero(50, 50);
  heights.col(25).setConstant(10);  // a wall with its crest at x = 25.5
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 50, 1);
  const auto under = surface.Intersect(From({1, 20, 10.1}, {49, 20, 9.7}));
  ASSERT_TRUE(under);
  EXPECT_NEAR(under->x(), 25.5, 0.1);
  EXPECT_FALSE(surface.Intersect(From({1, 20, 10.2}, {49, 20, 9.9})));  // leaves the DEM behind it
  const auto level = surface.Intersect({{1, 20, 5}, {1, 0, 0}});
  ASSERT_TRUE(level);
  EXPECT_NEAR(level->x(), 25, kOnSurface_m);  // half way up
  EXPECT_FALSE(surface.Intersect({{1, 20, 11}, {1, 0, 0}}));
}

TEST(GroundSurface, RaysThatDoNotMeetTheGroundHaveNoPoint) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(10, 10, 50.f);
  heights.block(3, 3, 4, 4).setConstant(kNone);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  EXPECT_TRUE(surface.Intersect({{1, 1, 500}, {0, 0, -1}}));
  EXPECT_FALSE(surface.Intersect({{1, 1, 500}, {0, 0, 1}})) << "points up";
  EXPECT_FALSE(surface.Intersect({{1, 1, 40}, {0, 0, -1}})) << "starts under the ground";
  EXPECT_FALSE(surface.Intersect({{5, 5, 500}, {0, 0, -1}})) << "only nodata";
  EXPECT_FALSE(surface.Intersect({{90, 1, 500}, {0, 0, -1}})) << "beside the DEM";
  EXPECT_FALSE(surface.Intersect(From({1, 1, 500}, {400, 1, 50}))) << "leaves the DEM";
  EXPECT_FALSE(surface.Intersect({{1, 1, 500}, {0, std::nan(""), -1}}));
  // Comes down inside the hole and would come out of the ground beyond it: hidden, not seen.
  EXPECT_FALSE(surface.Intersect(From({5, 5, 51}, {9, 5, 48})));
}

TEST(GroundSurface, ARayMayPassOverAHole) {
  Eigen::MatrixXf heights = Eigen::MatrixXf::Constant(10, 20, 50.f);
  heights.block(0, 5, 10, 3).setConstant(kNone);
  const GroundSurface surface = GroundSurface::FromGrid(heights, 0, 10, 1);
  const auto hit = surface.Intersect(From({-100, 5, 160}, {10, 5, 50}));
  ASSERT_TRUE(hit);
  EXPECT_NEAR(hit->x(), 10, kOnSurface_m);
}

// ---- files -------------------------------------------------------------------------------------

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
  dem = SmallDem();
  dem.heights.setConstant(kNone);
  expect(Refusal(WriteDem(folder / "hole", dem)), "hole.vrt", "only nodata");
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

}  // namespace
}  // namespace orient
