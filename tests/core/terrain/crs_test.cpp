#include "core/terrain/crs.h"

#include <gtest/gtest.h>

#include <fstream>

#include "core/base/error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr char kLo25[] =
    "+proj=tmerc +lat_0=0 +lon_0=25 +k=1 +x_0=0 +y_0=0 +datum=WGS84 +units=m +no_defs";

std::string Refusal(const std::string& definition) {
  try {
    Crs::Parse(definition, "block.toml: crs");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool Has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Crs, ReadsEpsgCodesProjStringsAndWkt) {
  EXPECT_EQ(Crs::Parse("EPSG:32635", "test").Epsg(), 32635);
  EXPECT_EQ(Crs::Parse("EPSG:32635", "test").Name(), "WGS 84 / UTM zone 35N");
  EXPECT_FALSE(Crs::Parse(kLo25, "test").Epsg());
  const Crs utm = Crs::Parse(" EPSG:32635\n", "test");
  EXPECT_TRUE(Crs::Parse(utm.Wkt(), "test").SameAs(utm));
  EXPECT_TRUE(Crs::Parse(utm.Wkt1(), "test").SameAs(utm));
  const Crs lo25 = Crs::Parse(kLo25, "test");
  EXPECT_TRUE(Crs::Parse(lo25.Wkt1(), "test").SameAs(lo25));
  EXPECT_EQ(lo25.Name().rfind("+proj=tmerc +lat_0=0 +lon_0=25", 0), 0u) << lo25.Name();
}

TEST(Crs, TheSameWhateverTheSpelling) {
  const Crs code = Crs::Parse("EPSG:32635", "test");
  EXPECT_TRUE(code.SameAs(Crs::Parse("+proj=utm +zone=35 +datum=WGS84 +units=m", "test")));
  EXPECT_FALSE(code.SameAs(Crs::Parse("EPSG:32636", "test")));
  EXPECT_FALSE(code.SameAs(Crs::Parse("EPSG:25835", "test")));  // ETRS89, not WGS 84
}

TEST(Crs, OfACompoundCrsOnlyTheHorizontalPartCounts) {
  const Crs compound = Crs::Parse("EPSG:32635+5773", "test");
  EXPECT_TRUE(compound.SameAs(Crs::Parse("EPSG:32635", "test")));
  EXPECT_FALSE(Has(compound.Wkt(), "VERT"));
}

TEST(Crs, ThePublishedOrientationHasAProjString) {
  ORIENT_REQUIRE_SHARED_DATA(path, "ngi/published_orientation.prj");
  EXPECT_TRUE(Crs::FromFile(path).SameAs(Crs::Parse(kLo25, "test")));
}

TEST(Crs, RefusesWhatIsNotProjectedInMetresToTheEastAndNorth) {
  EXPECT_TRUE(Has(Refusal("EPSG:4326"), "geographic"));
  EXPECT_TRUE(Has(Refusal("EPSG:2264"), "foot")) << Refusal("EPSG:2264");  // US survey feet
  EXPECT_TRUE(Has(Refusal("+proj=utm +zone=35 +datum=WGS84 +units=km"), "not in metres"));
  EXPECT_TRUE(Has(Refusal("EPSG:2053"), "axes"));           // Hartebeesthoek94 / Lo29: west, south
  EXPECT_TRUE(Has(Refusal("EPSG:5513"), "axes"));           // S-JTSK / Krovak: south, west
  EXPECT_TRUE(Has(Refusal("EPSG:4978"), "not projected"));  // geocentric
  EXPECT_TRUE(Has(Refusal("EPSG:5773"), "not projected"));  // heights only
}

TEST(Crs, ARefusalNamesOriginValueAndRemedy) {
  for (const char* bad : {"EPSG:4326", "nonsense", "", "EPSG:99999999", "/etc/passwd"}) {
    const std::string message = Refusal(bad);
    EXPECT_TRUE(Has(message, "block.toml: crs")) << message;
    EXPECT_TRUE(Has(message, std::string("'") + bad + "'")) << message;
    EXPECT_TRUE(Has(message, "EPSG:32635")) << message;
  }
}

TEST(Crs, NorthFirstInTheRegistryIsStillEastFirstHere) {
  // EPSG:31467 (Gauss-Krueger) and EPSG:3006 list northing first.
  const Crs crs = Crs::Parse("EPSG:3006", "test");
  const auto xy = CoordinateTransform::Between(crs.Wkt(), "EPSG:4326")({15, 60});
  ASSERT_TRUE(xy);
  EXPECT_NEAR(xy->x(), 500000, 1e-3);
  EXPECT_GT(xy->y(), 6.6e6);
}

TEST(Crs, PolarStereographicIsWelcome) {
  EXPECT_NO_THROW(Crs::Parse("EPSG:3413", "test"));
  EXPECT_NO_THROW(Crs::Parse("EPSG:3031", "test"));
}

TEST(Crs, FromAMissingFileNamesIt) {
  try {
    Crs::FromFile("no/such/file.prj");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_TRUE(Has(error.what(), "no/such/file.prj"));
  }
}

TEST(CoordinateTransform, LeadsThereAndBack) {
  const Crs zone35 = Crs::Parse("EPSG:32635", "test"), zone36 = Crs::Parse("EPSG:32636", "test");
  const CoordinateTransform there(zone36, zone35), back(zone35, zone36);
  const Eigen::Vector2d place(700000, 5000000);
  const auto moved = there(place);
  ASSERT_TRUE(moved);
  EXPECT_LT(moved->x(), 300000);  // near the western border of zone 36
  EXPECT_LT((back(*moved).value() - place).norm(), 1e-4);
}

TEST(CoordinateTransform, AgreesWithAPublishedPoint) {
  // The equator at the central meridian of zone 35 (27 degrees east).
  const auto xy = CoordinateTransform::Between("EPSG:32635", "EPSG:4326")({27, 0});
  ASSERT_TRUE(xy);
  EXPECT_NEAR(xy->x(), 500000, 1e-6);
  EXPECT_NEAR(xy->y(), 0, 1e-6);
}

TEST(CoordinateTransform, UndefinedPlacesHaveNoValue) {
  const auto transform = CoordinateTransform::Between("EPSG:32635", "EPSG:4326");
  EXPECT_FALSE(transform({27, 95}));
  EXPECT_FALSE(transform({std::nan(""), 0}));
}

}  // namespace
}  // namespace orient
