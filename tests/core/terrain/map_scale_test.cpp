#include "core/terrain/map_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

constexpr double kA = 6378137, kE2 = 0.00669437999014, kDegree = std::numbers::pi / 180;

Crs Of(const std::string& definition) { return Crs::Parse(definition, "test"); }

Eigen::Vector2d Place(const Crs& crs, double lon_deg, double lat_deg) {
  return CoordinateTransform::Between(crs.Wkt(), "EPSG:4326")({lon_deg, lat_deg}).value();
}

MapScale ScaleIn(const std::string& definition, double lon_deg, double lat_deg) {
  const Crs crs = Of(definition);
  return MapScaleAt(crs, Place(crs, lon_deg, lat_deg)).value();
}

Bounds Around(const Crs& crs, double lon_deg, double lat_deg, double reach_m = 5000) {
  const Eigen::Vector2d at = Place(crs, lon_deg, lat_deg);
  return {at.x() - reach_m, at.y() - reach_m, at.x() + reach_m, at.y() + reach_m};
}

void ExpectScale(const MapScale& scale, double least, double largest, double tolerance = 1e-7) {
  EXPECT_NEAR(scale.least, least, tolerance);
  EXPECT_NEAR(scale.largest, largest, tolerance);
}

TEST(MapScale, OfUtmIsItsFactorOnTheCentralMeridian) {
  for (const double lat : {0.0, 47.0, 83.0})
    ExpectScale(ScaleIn("EPSG:32635", 27, lat), .9996, .9996);
}

TEST(MapScale, OfUtmGrowsWithTheSquareOfTheDistanceFromTheMeridian) {
  const Crs utm = Of("EPSG:32635");
  const double lat = 47 * kDegree, w = 1 - kE2 * std::pow(std::sin(lat), 2);
  const double radius2 = kA * kA * (1 - kE2) / (w * w);  // M N of the ellipsoid
  const Eigen::Vector2d at = Place(utm, 29.5, 47);
  const double x = (at.x() - 500000) / .9996;
  const double expected = .9996 * (1 + x * x / (2 * radius2));
  const MapScale scale = MapScaleAt(utm, at).value();
  ExpectScale(scale, expected, expected, 1e-6);
}

// On the ellipsoid: N cos(lat) to the east is R radians of longitude, M to the north R / cos(lat).
TEST(MapScale, OfWebMercatorIsTheSecantOfTheLatitudeAndDiffersByDirection) {
  for (const double lat_deg : {0.0, 30.0, 47.0, 70.0}) {
    const double lat = lat_deg * kDegree, w2 = 1 - kE2 * std::pow(std::sin(lat), 2);
    const double n = kA / std::sqrt(w2), m = kA * (1 - kE2) / (w2 * std::sqrt(w2));
    ExpectScale(ScaleIn("EPSG:3857", 27, lat_deg), kA / n / std::cos(lat), kA / m / std::cos(lat));
  }
}

TEST(MapScale, OfEqualAreaMapsHasAProductOfOne) {
  const MapScale scale = ScaleIn("EPSG:3035", 27, 47);
  EXPECT_GT(scale.largest, 1.004);
  EXPECT_NEAR(scale.least * scale.largest, 1, 1e-8);
}

TEST(MapScale, IsKnownAtThePoleAndAcrossTheDateLine) {
  ExpectScale(MapScaleAt(Of("EPSG:5041"), {2e6, 2e6}).value(), .994, .994);
  ExpectScale(MapScaleAt(Of("EPSG:5042"), {2e6, 2e6}).value(), .994, .994);
  const Crs east = Of("+proj=tmerc +lon_0=180 +k=1 +ellps=GRS80 +units=m +no_defs");
  ExpectScale(MapScaleAt(east, {0, 2e6}).value(), 1, 1);
}

// NTF (Paris) counts longitudes in grads from Paris; its Lambert zone II has 0.99987742.
TEST(MapScale, TakesTheUnitsAndTheEllipsoidOfTheCrs) {
  ExpectScale(MapScaleAt(Of("EPSG:27572"), {600000, 2200000}).value(), .99987742, .99987742, 1e-6);
  ExpectScale(
      MapScaleAt(Of("+proj=tmerc +lon_0=9 +k=1 +x_0=0 +a=6400000 +b=6300000 +units=m"), {0, 5e6})
          .value(),
      1, 1);
}

TEST(MapScale, OutsideTheProjectionIsUnknown) {
  EXPECT_FALSE(MapScaleAt(Of("EPSG:3035"), {1e9, 1e9}));
  EXPECT_NO_THROW(RefuseFalseScale(Of("EPSG:3035"), {1e9, 1e9, 1.1e9, 1.1e9}));
}

TEST(MapScale, NationalGridsAreTrueInTheirArea) {
  struct Grid {
    const char* crs;
    double lon_deg, lat_deg;
  };
  for (const Grid& grid : std::initializer_list<Grid>{
           {"EPSG:32635", 24, 0},     {"EPSG:32635", 21, 60},   {"EPSG:25832", 12, 47.5},
           {"EPSG:2056", 10.4, 46.5}, {"EPSG:2154", -4.7, 48},  {"EPSG:2154", 9.4, 41.5},
           {"EPSG:31467", 11, 48},    {"EPSG:27700", -7.5, 57}, {"EPSG:27700", 1.7, 52.5},
           {"EPSG:3006", 24, 67},     {"EPSG:3067", 31, 62},    {"EPSG:2193", 167, -46},
           {"EPSG:2193", 178.3, -38}, {"EPSG:28992", 7, 53},    {"EPSG:31370", 6, 50},
           {"EPSG:2180", 24, 51},     {"EPSG:5514", 22.4, 49},  {"EPSG:23700", 22.5, 48},
           {"EPSG:26945", -118, 35},  {"EPSG:32140", -100, 28}, {"EPSG:3068", 13.7, 52.4},
           {"EPSG:3413", -50, 69},    {"EPSG:3031", 20, -70},   {"EPSG:5041", 10, 84},
           {"EPSG:5042", 10, -80},    {"EPSG:3035", 11, 50},    {"EPSG:3395", 20, 2}}) {
    const Crs crs = Of(grid.crs);
    EXPECT_NO_THROW(RefuseFalseScale(crs, Around(crs, grid.lon_deg, grid.lat_deg))) << grid.crs;
  }
}

TEST(MapScale, MapsOfContinentsAreRefusedFarFromWhereTheyAreTrue) {
  struct Map {
    const char* crs;
    double lon_deg, lat_deg;
    const char* instead;
  };
  for (const Map& map : std::initializer_list<Map>{
           {"EPSG:3857", 27.1, 47, "EPSG:32635"},
           {"EPSG:3857", 27.1, 0.1, "EPSG:32635"},  // 1 to the east, 1.0067 to the north
           {"EPSG:3395", -70, -33, "EPSG:32719"},
           {"EPSG:3031", 100, -82, "EPSG:5042"},
           {"EPSG:3995", 20, 86, "EPSG:5041"},
           {"EPSG:3995", -50, 64, "EPSG:32622"},
           {"EPSG:3408", 10, 66, "EPSG:32632"},
           {"EPSG:3034", 10, 50, "EPSG:32632"},
           {"EPSG:3035", 27, 47, "EPSG:32635"},
           {"EPSG:5070", -96, 33, "EPSG:32614"}}) {
    const Crs crs = Of(map.crs);
    ExpectError<InputError>([&] { RefuseFalseScale(crs, Around(crs, map.lon_deg, map.lat_deg)); },
                            {crs.Name(), "heights", "poses would be wrong", map.instead});
  }
}

TEST(MapScale, ARefusalNamesScaleAndPlace) {
  const Crs crs = Of("EPSG:3857");
  ExpectError<InputError>([&] { RefuseFalseScale(crs, Around(crs, -70.5, -33.25)); },
                          {"1.19", "33.25 S, 70.50 W", "WGS 84 / UTM zone 19S"});
}

// Its middle says nothing of a DEM of the world; the commands read the part under the photos.
TEST(MapScale, AnAreaThatIsTrueSomewhereIsNotRefused) {
  EXPECT_NO_THROW(RefuseFalseScale(Of("EPSG:3395"), {-2e7, -1.5e7, 2e7, 1.5e7}));
}

TEST(MapScale, TheFittingCrsIsUtmAndUpsNearThePoles) {
  EXPECT_EQ(FittingEpsg(27, 47), 32635);
  EXPECT_EQ(FittingEpsg(-70, -33), 32719);
  EXPECT_EQ(FittingEpsg(-180, 10), 32601);
  EXPECT_EQ(FittingEpsg(180, 10), 32601);
  EXPECT_EQ(FittingEpsg(179.9, -10), 32760);
  EXPECT_EQ(FittingEpsg(207, 10), FittingEpsg(-153, 10));
  EXPECT_EQ(FittingEpsg(0, 83.9), 32631);
  EXPECT_EQ(FittingEpsg(0, 84), 5041);
  EXPECT_EQ(FittingEpsg(0, -81), 5042);
}

}  // namespace
}  // namespace orient
