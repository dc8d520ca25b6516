#include "block/inputs/measurement_inputs.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/error.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"

namespace orient::block {
namespace {

Measurements Placed(const std::string& photo, const std::string& value) {
  Measurements measurements;
  measurements.decisions.push_back({photo, DecisionKind::kPosition, value, "", {}});
  return measurements;
}

std::vector<OrientationRow> Rows() {
  return {{"a", {{100, 200, 1500}, {0.01, 0, 2}}, {}}, {"b", {{400, 200, 1700}, {}}, {}}};
}

TEST(RequireKnownMarks, AMarkThatTheCameraDoesNotHaveIsNamedWithThoseItHas) {
  CameraFile camera;
  camera.camera.name = "Wild RC10";
  camera.fiducials.resize(2);
  camera.fiducials[0].id = "1";
  camera.fiducials[1].id = "2";
  Measurements measurements;
  measurements.folder = "said";
  measurements.marks = {{"a", "1", {1, 2}, 1, false, {}}, {"b", "12", {1, 2}, 1, false, {}}};
  EXPECT_NO_THROW(RequireKnownMarks(measurements, "a", camera));
  ExpectError<InputError>([&] { RequireKnownMarks(measurements, "b", camera); },
                          {"said/marks.csv", "photo b", "\"12\"", "Wild RC10", "1, 2"});
  camera.fiducials.clear();
  ExpectError<InputError>([&] { RequireKnownMarks(measurements, "a", camera); }, {"has no marks"});
}

TEST(ApplyDecidedPositions, TheSaidPlaceStandsInForTheTablesAndItsAccuracyToo) {
  std::vector<OrientationRow> rows = Rows();
  ApplyDecidedPositions(Placed("a", "130.5 -20 75"), {"a", "b"},
                        {.position_m = 5, .kappa_rad = 2.5}, {}, &rows);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].pose.position_m, Eigen::Vector3d(130.5, -20, 1500));
  EXPECT_EQ(rows[0].pose.opk_rad, Eigen::Vector3d(0.01, 0, 2));
  Vector6d sigma;
  sigma << 75, 75, 5, RadFromDeg(3), RadFromDeg(3), 2.5;
  EXPECT_LT((*rows[0].sigma - sigma).norm(), 1e-12);
  EXPECT_FALSE(rows[1].sigma) << "nothing was said of it";
}

TEST(ApplyDecidedPositions, APhotoThatNoRowKnowsIsAsHighAsTheOthersAndItsKappaUnknown) {
  std::vector<OrientationRow> rows = Rows();
  ApplyDecidedPositions(Placed("c", "1 2 300"), {"c"}, {}, {}, &rows);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[2].pose.position_m, Eigen::Vector3d(1, 2, 1600));
  EXPECT_FALSE(rows[2].attitude_known);
  EXPECT_EQ((*rows[2].sigma)[2], 300);
  ApplyDecidedPositions(
      Placed("d", "1 2 3"), {"d"}, {},
      [](const auto&) {
        return ExpectedHeight{990, 40};
      },
      &rows);
  EXPECT_EQ(rows[3].pose.position_m.z(), 990);
  EXPECT_EQ((*rows[3].sigma)[2], 40) << "as the flight's heights, not as the place";
  ApplyDecidedPositions(Placed("e", "1 2 3"), {"e"}, {}, {}, &rows);
  EXPECT_GT((*rows[4].sigma)[2], 100) << "as the heights differ";
  EXPECT_NEAR((*rows[2].sigma)[5], std::numbers::pi, 1e-12);
}

TEST(ApplyDecidedPositions, WithoutAnyHeightTheDecisionIsNamed) {
  std::vector<OrientationRow> rows = Rows(), none;
  ApplyDecidedPositions(Placed("c", "1 2 300"), {"a"}, {}, {}, &rows);
  EXPECT_EQ(rows.size(), 2u) << "none of the run's photos";
  EXPECT_THROW(ApplyDecidedPositions(Placed("c", "1 2 300"), {"c"}, {}, {}, &none), InputError);
}

TEST(DecidedPosition, IsThreeNumbers) {
  EXPECT_EQ(DecisionProblem(DecisionKind::kPosition, "500123.5 5000321 250"), "");
  for (const char* wrong : {"", "1 2", "1 2 0", "1 2 -3", "1 2 3 4", "1,2,3", "nan 2 3", "1 2 inf",
                            "1e99 2 3", "x y z"})
    EXPECT_NE(DecisionProblem(DecisionKind::kPosition, wrong), "") << wrong;
}

TEST(DecidedPosition, ConcernsTheExteriorAlone) {
  const Measurements measurements = Placed("a", "1 2 3");
  EXPECT_EQ(TextOfMarks(measurements, "a"), "");
  EXPECT_NE(TextOfPoints(measurements, "a"), "");
}

TEST(ApplyVerdict, ARejectedPhotoKeepsNothingOfItsPose) {
  Measurements measurements;
  measurements.decisions.push_back({"a", DecisionKind::kReject, "", "", {}});
  ExteriorResult result;
  result.photo = "a";
  result.status = Status::kOk;
  result.pose = Pose{};
  result.covariance = Matrix6d(Matrix6d::Identity());
  result.projection_sigma = ProjectionSigma{1, 2};
  result.footprint_m.resize(4);
  ApplyVerdict(measurements, &result);
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_FALSE(result.pose || result.covariance || result.projection_sigma);
  EXPECT_TRUE(result.footprint_m.empty());
}

TEST(UnknownPhotos, AreNamedWithThoseThatWerePerhapsMeant) {
  Measurements measurements;
  measurements.marks = {{"4711", "1", {1, 2}, 1, false, {}}};
  measurements.decisions.push_back({"4712", DecisionKind::kReject, "", "", {}});
  EXPECT_FALSE(UnknownPhotos(measurements, {"4711", "4712"}));
  measurements.image_points = {{"new_1_2", "p", Eigen::Vector2d(1, 2), std::nullopt, 1}};
  const auto unknown = UnknownPhotos(measurements, {"4711", "4712", "New_1_2"});
  ASSERT_TRUE(unknown);
  EXPECT_EQ(unknown->reason, Reason::kMeasuredPhotosUnknown);
  EXPECT_EQ(unknown->value, 1);
  EXPECT_EQ(unknown->where, "new_1_2 (is it New_1_2?)");
}

}  // namespace
}  // namespace orient::block
