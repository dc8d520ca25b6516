#include "block/inputs/approximations.h"

#include <gtest/gtest.h>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

class Approximations : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& text) const {
    WriteFileAtomically(folder_ / name, text);
    return folder_ / name;
  }
  OrientationTable Read(const std::string& path) const { return ReadApproximations(path, crs_); }
  // Two points, of features with these properties.
  static std::string GeoJson(const std::string& first, const std::string& properties) {
    return R"({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": )" +
           properties + R"(, "geometry": {"type": "Point", "coordinates": )" + first + "}}]}";
  }

  const TemporaryFolder folder_;
  const Crs crs_ = Crs::Parse("EPSG:32635", "test");
};

TEST_F(Approximations, ATableWithAnglesIsWhatItIs) {
  const auto table = Read(Write("a.csv", "filename,x,y,z,omega,phi,kappa\n4711,1,2,3,0.5,0,90\n"));
  EXPECT_TRUE(table.rows.at(0).attitude_known);
  EXPECT_DOUBLE_EQ(table.rows[0].pose.opk_rad[2], RadFromDeg(90));
}

TEST_F(Approximations, ATableWithoutAnglesHasPositionsAlone) {
  const auto table = Read(Write("a.csv", "filename,x,y,z\n4711,500000.5,5000000,1800\n"));
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_FALSE(table.rows[0].attitude_known);
  EXPECT_EQ(table.rows[0].pose.position_m, Eigen::Vector3d(500000.5, 5000000, 1800));
  EXPECT_EQ(table.rows[0].pose.opk_rad, Eigen::Vector3d::Zero());
}

TEST_F(Approximations, OneAngleWithoutTheOthersIsAMistake) {
  const std::string path = Write("a.csv", "filename,x,y,z,kappa\n4711,1,2,3,90\n");
  ExpectError<InputError>([&] { Read(path); }, {path, "omega"});
  const std::string without = Write("b.csv", "filename,x,y,z\n4711,1,2,3\n");
  ExpectError<InputError>([&] { ReadOrientationTable(without); }, {without, "omega"});
}

// The central meridian of UTM zone 35 at the equator is 500 km east, 0 north.
TEST_F(Approximations, PointsOfAFlightIndexComeIntoTheBlocksCrs) {
  const std::string path =
      Write("flight.geojson", GeoJson("[27.0, 0.0, 1823.5]", R"({"photo": "scans/4711.tif"})"));
  const auto table = Read(path);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_EQ(table.rows[0].photo, "4711");
  EXPECT_FALSE(table.rows[0].attitude_known);
  EXPECT_LT((table.rows[0].pose.position_m - Eigen::Vector3d(500000, 0, 1823.5)).norm(), 1e-3);
  EXPECT_TRUE(table.crs && table.crs->SameAs(crs_));
}

TEST_F(Approximations, AHeightColumnCountsBeforeThePointsOwn) {
  const auto table = Read(Write(
      "flight.geojson", GeoJson("[27.0, 0.0, 0.0]", R"({"name": "4711", "altitude": 2400})")));
  EXPECT_EQ(table.rows.at(0).pose.position_m.z(), 2400);
}

TEST_F(Approximations, WhatAFlightIndexLacksIsNamed) {
  const auto refused = [&](const std::string& text, const std::string& part) {
    const std::string path = Write("flight.geojson", text);
    ExpectError<InputError>([&] { Read(path); }, {path, part});
  };
  refused(GeoJson("[27.0, 0.0]", R"({"name": "4711"})"), "height");
  refused(GeoJson("[27.0, 0.0, 9.0]", R"({"strip": "4711"})"), "filename");
  refused(GeoJson("[27.0, 0.0, 9.0]", R"({"name": ""})"), "name");
  refused("this is no vector file", "flight.geojson");
}

}  // namespace
}  // namespace orient::block
