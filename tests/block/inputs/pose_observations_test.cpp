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
  EXPECT_TRUE(ObservationsOf(block_, table, {}, {}).Empty()) << "unless they are wanted";
  block_.observe_approximations = true;
  const PoseObservations by_table = ObservationsOf(block_, table, {"computed"}, {});
  EXPECT_EQ(by_table.approximations.size(), 1u);
  EXPECT_TRUE(SigmaOf(by_table, "stated").isApproxToConstant(0.25));

  block_.position_sigma_m = 2;
  const PoseObservations by_block = ObservationsOf(block_, table, {"computed"}, {});
  EXPECT_EQ(by_block.approximations.size(), 4u);
  EXPECT_EQ(SigmaOf(by_block, "computed")[1], 2);
  EXPECT_GT(SigmaOf(by_block, "computed")[2], 1e4) << "a height that nobody gave";
  EXPECT_TRUE(SigmaOf(by_block, "bare").head<3>().isApproxToConstant(2));
  EXPECT_TRUE(SigmaOf(by_block, "bare").tail<3>().isApproxToConstant(std::numbers::pi))
      << "nobody states attitudes";
  EXPECT_TRUE(SigmaOf(by_block, "stated").isApproxToConstant(0.25));

  block_.attitude_sigma_rad = 0.01;
  const PoseObservations with_attitude = ObservationsOf(block_, table, {"computed"}, {});
  EXPECT_TRUE(SigmaOf(with_attitude, "bare").tail<3>().isApproxToConstant(0.01));
  EXPECT_TRUE(SigmaOf(with_attitude, "alone").tail<3>().isApproxToConstant(std::numbers::pi));
}

TEST_F(PoseObservationsOf, GnssRowsWithoutAPositionAreRemarked) {
  block_.gnss.sigma_m = 0.1;
  EXPECT_EQ(Gnss("filename,x,y,z,yaw\na,1,2,3,9\nb,,2,3,9\nc,1,,3,9\n").size(), 1u);
  EXPECT_EQ(remarks_, (Findings{{.reason = Reason::kRowsWithoutPosition,
                                 .value = 2,
                                 .where = folder_ / "gnss.csv" + ": b, c"}}));
  EXPECT_EQ(Sentence(remarks_[0]), folder_ / "gnss.csv" +
                                       " leaves x or y of 2 photos empty, which are taken to be "
                                       "absent from it: b, c");
}

TEST_F(PoseObservationsOf, GnssKnowsItsStripAndItsPlaceAlongIt) {
  const auto gnss = Gnss(
      "filename,x,y,z,sigma_x,sigma_y,sigma_z\n"
      "a,1,2,3,0.1,0.2,0.3\nb,4,5,6,0.1,0.2,0.3\nother,7,8,9,0.1,0.2,0.3\n");
  block_.flight.strips = {{"05", {"a", "not_scanned", "b"}, std::nullopt}};
  const PoseObservations observations = ObservationsOf(block_, {}, {}, gnss);
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
