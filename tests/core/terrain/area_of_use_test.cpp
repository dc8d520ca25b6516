#include "core/terrain/area_of_use.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(AreaOfUse, HoldsCoordinatesInAndAroundIt) {
  const Crs utm = Crs::Parse("EPSG:32635", "test");
  for (const Crs& crs : {utm, Crs::Parse(utm.Wkt1(), "WKT1 without an area")}) {
    EXPECT_TRUE(MayHold(crs, {512000, 5204000}));
    EXPECT_TRUE(MayHold(crs, {923000, 5650000})) << "the neighbouring zone's";
    EXPECT_FALSE(MayHold(crs, {-344, 71})) << "an origin was left out";
    EXPECT_FALSE(MayHold(crs, {5204000, 512000})) << "north before east";
  }
}

TEST(AreaOfUse, WhereNoneIsStatedHoldsAnything) {
  EXPECT_TRUE(MayHold(Crs::Parse("+proj=tmerc +lon_0=25 +datum=WGS84 +units=m +no_defs", "test"),
                      {-344, 71}));
}

TEST(AreaOfUse, HoldsTheCoordinatesZeroWhereThatIsInUse) {
  EXPECT_TRUE(MayHold(Crs::Parse("EPSG:3857", "test"), {100, 100}));
  EXPECT_TRUE(MayHold(Crs::Parse("EPSG:3031", "test"), {100, 100}));
  EXPECT_FALSE(MayHold(Crs::Parse("EPSG:28992", "test"), {100, 100}));
}

}  // namespace
}  // namespace orient
