#include "block/inputs/approximations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/dem_files.h"
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

TEST_F(Approximations, WithKappaAlonePhotosLookDown) {
  const OrientationRow row =
      Read(Write("a.csv", "filename,x,y,z,kappa\n4711,1,2,3,90\n")).rows.at(0);
  EXPECT_TRUE(row.attitude_known);
  EXPECT_EQ(row.pose.opk_rad, Eigen::Vector3d(0, 0, RadFromDeg(90)));
  const Vector6d sigma = SigmaOfApproximation(row, std::nullopt, std::nullopt);
  EXPECT_EQ(sigma.tail<3>(), Eigen::Vector3d::Constant(kAttitudeSigma_rad));
}

TEST_F(Approximations, OneOfOmegaAndPhiIsAMistake) {
  const std::string path = Write("a.csv", "filename,x,y,z,phi,kappa\n4711,1,2,3,0,90\n");
  ExpectError<InputError>([&] { Read(path); }, {path, "line 1", "phi", "omega"});
  const std::string without = Write("b.csv", "filename,x,y,z\n4711,1,2,3\n");
  ExpectError<InputError>([&] { ReadOrientationTable(without); }, {without, "omega"});
}

TEST_F(Approximations, ATableMayLackHeightsWhereTheFlyingHeightIsStated) {
  const std::string path = Write("a.csv", "filename,x,y\n1,500100,5009900\n");
  ExpectError<InputError>([&] { Read(path); }, {path, "flying_height_m", "scale", "[flight]"});
  auto table = ReadApproximations(path, crs_, Heights::kMayBeAbsent);
  EXPECT_TRUE(std::isnan(table.rows.at(0).pose.position_m.z()));

  DemFile dem;
  dem.heights = Eigen::MatrixXf::Constant(20, 20, 300);
  dem.west = 500000;
  dem.north = 5010000;
  dem.cell_x = dem.cell_y = 100;
  WriteDem(folder_ / "dem", dem);
  table.rows.push_back({.photo = "2", .pose = {}, .sigma = {}});
  table.rows[1].pose.position_m = {500200, 5009800, 1750};
  table.rows[0].sigma = table.rows[1].sigma = Vector6d::Ones();
  EXPECT_EQ(CompleteHeights(folder_ / "dem.vrt", crs_, 1500, &table.rows),
            std::set<std::string>{"1"});
  EXPECT_NEAR(table.rows[0].pose.position_m.z(), 1800, 1e-6);
  EXPECT_EQ(table.rows[1].pose.position_m.z(), 1750);
  EXPECT_EQ((*table.rows[0].sigma)[2], 75) << "5 % of the flying height";
  EXPECT_EQ((*table.rows[0].sigma)[0], 1);
  EXPECT_EQ((*table.rows[1].sigma)[2], 1);

  // The same where the table has no sigmas.
  table.rows[0].pose.position_m.z() = std::nan("");
  table.rows[0].sigma = table.rows[1].sigma = std::nullopt;
  CompleteHeights(folder_ / "dem.vrt", crs_, 1500, &table.rows);
  const Vector6d computed = SigmaOfApproximation(table.rows[0], 20, {});
  EXPECT_EQ(computed[2], 75);
  EXPECT_EQ(computed[0], 20);
  EXPECT_EQ(SigmaOfApproximation(table.rows[1], 20, {})[2], 20);
  EXPECT_EQ(SigmaOfApproximation(table.rows[0], 200, {})[2], 200);
}

// A lake without heights in low ground beside a plateau.
TEST_F(Approximations, OverAHoleInTheDemTheFlyingHeightIsAboveTheGroundAround) {
  DemFile dem;
  dem.heights = Eigen::MatrixXf::Constant(60, 60, 300);
  dem.heights.rightCols(20).setConstant(1500);
  dem.heights.block(20, 10, 20, 20).setConstant(std::numeric_limits<float>::quiet_NaN());
  dem.west = 500000;
  dem.north = 5010000;
  dem.cell_x = dem.cell_y = 100;
  WriteDem(folder_ / "dem", dem);
  std::vector<OrientationRow> rows(1);
  rows[0].photo = "1";
  rows[0].pose.position_m = {502000, 5007000, std::nan("")};
  EXPECT_EQ(CompleteHeights(folder_ / "dem.vrt", crs_, 1500, &rows), std::set<std::string>{"1"});
  EXPECT_NEAR(rows[0].pose.position_m.z(), 1800, 1e-6);
}

TEST_F(Approximations, WhatATableDoesNotUseIsRemarked) {
  const std::string path = Write("a.csv", "filename,x,y,z,yaw,Kappa [gon]\n1,1,2,3,4,5\n2,,,,,\n");
  const Findings remarks = RemarksOn(Read(path), path);
  EXPECT_EQ(
      remarks,
      (Findings{{.reason = Reason::kAngleColumnsIgnored,
                 .value = 2,
                 .where = path + ": yaw, Kappa [gon]"},
                {.reason = Reason::kRowsWithoutPosition, .value = 1, .where = path + ": 2"}}));
  EXPECT_TRUE(RemarksOn(Read(Write("b.csv", "filename,x,y,z\n1,1,2,3\n")), path).empty());
}

TEST_F(Approximations, PhotosOfSeveralCamerasAreRefused) {
  const std::string path =
      Write("a.csv", "filename,x,y,z,camera\n1,1,2,3,c1\n2,1,2,3,c2\n3,1,2,3,\n4,1,2,3,c1\n");
  const auto table = Read(path);
  ExpectError<InputError>([&] { RequireOneCamera(table, path, {"1", "2"}); }, {path, "c1, c2"});
  EXPECT_NO_THROW(RequireOneCamera(table, path, {"1", "3", "4"})) << "2 is no photo of the block";
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

TEST_F(Approximations, AHeightMayBeWrittenAsTextAndMustBeANumberThen) {
  const auto read = [&](const std::string& height) {
    return Read(Write("flight.geojson",
                      GeoJson("[27.0, 0.0]", R"({"name": "4711", "z": ")" + height + "\"}")));
  };
  EXPECT_EQ(read("+2400.5").rows.at(0).pose.position_m.z(), 2400.5);
  EXPECT_EQ(
      Read(Write("flight.geojson", GeoJson("[27.0, 0.0, 900.0]", R"({"name": "4711", "z": " "})")))
          .rows.at(0)
          .pose.position_m.z(),
      900);
  EXPECT_EQ(read(" 2400.5").rows.at(0).pose.position_m.z(), 2400.5);
  for (const char* wrong : {"n/a", "1 500", "2400,5"})
    ExpectError<InputError>([&] { read(wrong); }, {"flight.geojson", wrong, "not a number"});
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
  refused(GeoJson("[]", R"({"name": "4711", "z": 1200})"), "point");
}

}  // namespace
}  // namespace orient::block
