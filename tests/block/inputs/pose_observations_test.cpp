#include "block/inputs/pose_observations.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

class PoseObservationsOf : public testing::Test {
 protected:
  std::vector<OrientationRow> Gnss(const std::string& table) {
    WriteFileAtomically(folder_ / "gnss.csv", table);
    block_.gnss.positions = folder_ / "gnss.csv";
    remarks_.clear();
    return ReadGnss(block_, &remarks_);
  }

  static OrientationRow Row(const std::string& photo) {
    OrientationRow row;
    row.photo = photo;
    row.pose.position_m << 400000, 6000000, 1500;
    return row;
  }

  static Vector6d SigmaOf(const PoseObservations& observations, const std::string& photo) {
    return observations.approximations.at(photo).covariance.diagonal().cwiseSqrt();
  }

  const TemporaryFolder folder_;
  BlockFile block_{.crs = Crs::Parse("EPSG:32635", "test")};
  Findings remarks_;
};

TEST_F(PoseObservationsOf, ApproximationsAreObservedAsFarAsSomebodySaysHowGoodTheyAre) {
  OrientationRow stated = Row("stated"), alone = Row("alone");
  stated.sigma = Vector6d::Constant(0.25);
  alone.attitude_known = false;
  const std::vector<OrientationRow> table = {Row("bare"), stated, alone, Row("computed")};
  EXPECT_TRUE(ObservationsOf(block_, StatedApproximations(block_, table, {}), {}).Empty())
      << "unless they are wanted";
  block_.observe_approximations = true;
  const PoseObservations by_table =
      ObservationsOf(block_, StatedApproximations(block_, table, {"computed"}), {});
  EXPECT_EQ(by_table.approximations.size(), 1u);
  EXPECT_TRUE(SigmaOf(by_table, "stated").isApproxToConstant(0.25));

  block_.position_sigma_m = 2;
  const PoseObservations by_block =
      ObservationsOf(block_, StatedApproximations(block_, table, {"computed"}), {});
  EXPECT_EQ(by_block.approximations.size(), 4u);
  EXPECT_EQ(SigmaOf(by_block, "computed")[1], 2);
  EXPECT_GT(SigmaOf(by_block, "computed")[2], 1e4) << "a height that nobody gave";
  EXPECT_TRUE(SigmaOf(by_block, "bare").head<3>().isApproxToConstant(2));
  EXPECT_TRUE(SigmaOf(by_block, "bare").tail<3>().isApproxToConstant(std::numbers::pi))
      << "nobody states attitudes";
  EXPECT_TRUE(SigmaOf(by_block, "stated").isApproxToConstant(0.25));

  block_.attitude_sigma_rad = 0.01;
  const PoseObservations with_attitude =
      ObservationsOf(block_, StatedApproximations(block_, table, {"computed"}), {});
  EXPECT_TRUE(SigmaOf(with_attitude, "bare").tail<3>().isApproxToConstant(0.01));
  EXPECT_TRUE(SigmaOf(with_attitude, "alone").tail<3>().isApproxToConstant(std::numbers::pi));
}

TEST_F(PoseObservationsOf, GnssRowsThatLeaveACoordinateEmptyAreNamedAndLeftOut) {
  block_.gnss.sigma_m = 0.1;
  EXPECT_EQ(Gnss("filename,x,y,z,yaw\na,1,2,3,9\nb,,2,3,9\nc,1,,3,9\nd,1,2,,9\n").size(), 1u);
  EXPECT_EQ(remarks_, (Findings{{.reason = Reason::kRowsWithoutPosition,
                                 .value = 3,
                                 .where = folder_ / "gnss.csv" + ": b, c, d"}}));
  EXPECT_EQ(Sentence(remarks_[0]), folder_ / "gnss.csv" +
                                       " has no complete position of 3 photos, which are treated "
                                       "as if not listed: b, c, d");
  const auto with_sigmas =
      Gnss("filename,x,y,z,sigma_x,sigma_y,sigma_z\na,1,2,,0.1,0.1,0.1\nb,1,2,3,0.1,0.1,0.1\n");
  ASSERT_EQ(with_sigmas.size(), 1u);
  EXPECT_EQ(with_sigmas[0].photo, "b");
}

TEST_F(PoseObservationsOf, GnssOfWhichNoRowIsWholeIsRefused) {
  block_.gnss.sigma_m = 0.1;
  for (const char* table : {"filename,x,y,z\na,1,2,\nb,,2,3\n", "filename,x,y\na,1,2\n"})
    ExpectError<InputError>([&] { Gnss(table); }, {"gnss.csv", "no row", "x, y and z"});
}

TEST_F(PoseObservationsOf, GnssWhoseXAndYAreExchangedIsRefused) {
  block_.gnss.sigma_m = 0.1;
  block_.approximations = "approx.csv";
  const std::vector<OrientationRow> table = {Row("a"), Row("b"), Row("c")};
  const std::string right = "a,400100,6000000,1500\n", other = "d,6000000,400000,1500\n";
  const auto refuse = [&](const std::string& rows) {
    RefuseExchangedAxes(block_, table, Gnss("filename,x,y,z\n" + rows));
  };
  ExpectError<InputError>(
      [&] { refuse(right + other + "b,6000000,400000,1500\nc,6000300,400000,1500\n"); },
      {"gnss.csv", "x and y", "exchanged", "2 of 3", "approx.csv"});
  EXPECT_NO_THROW(refuse(right + other + "b,6000000,400000,1500\n"))
      << "one of two is that photo's own error";
  EXPECT_NO_THROW(refuse("a,500000,5000000,1500\nb,1,2,3\n")) << "far away, but not so";
  EXPECT_NO_THROW(refuse(other)) << "of photos that the table lacks nothing is known";
}

TEST_F(PoseObservationsOf, GnssKnowsItsStripAndItsPlaceAlongIt) {
  const auto gnss = Gnss(
      "filename,x,y,z,sigma_x,sigma_y,sigma_z\n"
      "a,1,2,3,0.1,0.2,0.3\nb,4,5,6,0.1,0.2,0.3\nother,7,8,9,0.1,0.2,0.3\n");
  block_.flight.strips = {{"05", {"a", "not_scanned", "b"}, std::nullopt}};
  const PoseObservations observations = ObservationsOf(block_, {}, gnss);
  EXPECT_EQ(observations.gnss.at("a").along_strip, -1);
  EXPECT_EQ(observations.gnss.at("b").along_strip, 1);
  EXPECT_EQ(observations.gnss.at("b").position_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_TRUE(observations.gnss.at("b").covariance_m2.diagonal().isApprox(
      Eigen::Vector3d(0.01, 0.04, 0.09)));
  EXPECT_EQ(observations.strip.at("b"), "05");
  EXPECT_FALSE(observations.strip.contains("other"));
}

TEST_F(PoseObservationsOf, GnssOfWhichNobodySaysHowGoodItIsOrInAnotherCrsIsRefused) {
  ExpectError<InputError>([&] { Gnss("filename,x,y,z\na,1,2,3\n"); },
                          {"gnss.csv", "position of a", "sigma_m under [gnss]"});
  block_.gnss.sigma_m = 0.1;
  EXPECT_TRUE(Gnss("filename,x,y,z\na,1,2,3\n").at(0).sigma->head<3>().isApproxToConstant(0.1));
  WriteFileAtomically(folder_ / "gnss.prj", Crs::Parse("EPSG:32631", "test").Wkt());
  ExpectError<InputError>([&] { Gnss("filename,x,y,z\na,1,2,3\n"); }, {"gnss.csv", "31N", "35N"});
}

}  // namespace
}  // namespace orient::block
