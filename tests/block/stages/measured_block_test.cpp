#include "block/stages/measured_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "block/verdict/point_table.h"
#include "core/base/error.h"
#include "core/base/table_text.h"
#include "core/geometry/rotation.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

// The published RC30 pair (a real camera) as the files of measurements have it.
class PublishedPair : public testing::Test {
 protected:
  void SetUp() override {
    camera_.camera.kind = CameraKind::kFilm;
    camera_.camera.principal_distance_mm = 154.006;
    camera_.camera.frame_mm = {230, 230};
  }

  bool Read() {
    const auto shared = SharedData("resection/rc30_pair");
    if (!shared) return false;
    const std::string& folder = *shared;
    constexpr double kSigma_mm = 0.005, kSurveyed_m = 0.02;
    NamedTable seen(folder + "/block_observations.csv", {"photo", "point", "x_mm", "y_mm"}, {});
    while (seen.Next())
      measured_.image_points.push_back({seen.Name("photo"), seen.Name("point"), std::nullopt,
                                        Eigen::Vector2d(seen.Number("x_mm"), seen.Number("y_mm")),
                                        kSigma_mm});
    NamedTable given(folder + "/control.csv", {"point", "x", "y", "z"}, {});
    while (given.Next())
      measured_.points.push_back({given.Name("point"),
                                  {given.Number("x"), given.Number("y"), given.Number("z")},
                                  Eigen::Vector3d::Constant(kSurveyed_m),
                                  PointRole::kControl});
    NamedTable expected(folder + "/published_result.csv",
                        {"parameter", "value", "precision", "unit"}, {});
    while (expected.Next())
      published_[expected.Name("parameter")] = {expected.Number("value"),
                                                expected.Number("precision")};
    return true;
  }
  MeasuredBlock Adjusted() const { return AdjustMeasurements({camera_, measured_}); }
  PointTable Table(const MeasuredBlock& done) const {
    return TableOfPoints(done.adjusted.surveyed, done.adjusted.block, done.adjusted.result);
  }

  CameraFile camera_;
  Measurements measured_;
  std::map<std::string, std::pair<double, double>> published_;  // value, precision
};

TEST_F(PublishedPair, IsAdjustedFromItsImageMeasurementsAlone) {
  if (!Read()) GTEST_SKIP() << "without the shared data";
  const MeasuredBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 2u);
  for (const ExteriorResult& result : done.results) {
    ASSERT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
    const Eigen::Vector3d degrees = result.pose->opk_rad * (180 / M_PI);
    const char* names = "XYZOPK";
    for (int i = 0; i < 6; ++i) {
      const auto& [value, precision] = published_.at(result.photo + "_15_" + names[i]);
      const double ours = i < 3 ? result.pose->position_m[i] : degrees[i - 3];
      EXPECT_NEAR(ours, value, i < 3 ? precision : precision / 3600) << result.photo << names[i];
    }
  }
  EXPECT_EQ(done.adjusted.ties, 6u);
  const PointTable table = Table(done);
  ASSERT_EQ(table.accuracy.size(), 1u);
  EXPECT_EQ(table.accuracy[0].points, 6);
  EXPECT_LT(table.accuracy[0].rmse_m.maxCoeff(), 0.02);
  EXPECT_NEAR(table.accuracy[0].le90_m, 1.6449 * table.accuracy[0].rmse_m.z(), 1e-9);
}

TEST_F(PublishedPair, CheckPointsAreHeldOut) {
  if (!Read()) GTEST_SKIP() << "without the shared data";
  measured_.points[3].role = PointRole::kCheck;  // in the middle of the overlap
  const PointTable table = Table(Adjusted());
  ASSERT_EQ(table.accuracy.size(), 2u);
  EXPECT_EQ(table.accuracy[1].role, "check");
  EXPECT_EQ(table.accuracy[1].points, 1);
  EXPECT_GT(table.accuracy[1].rmse_m.norm(), 0);
  EXPECT_LT(table.accuracy[1].rmse_m.maxCoeff(), 0.3);
}

TEST_F(PublishedPair, AWrongCoordinateIsNamedAndNotUsed) {
  if (!Read()) GTEST_SKIP() << "without the shared data";
  measured_.points[2].ground_m.x() += 5;
  const MeasuredBlock done = Adjusted();
  for (const ExteriorResult& result : done.results) {
    ASSERT_TRUE(result.pose);
    EXPECT_NEAR(result.pose->position_m.x(), published_.at(result.photo + "_15_X").first, 0.6);
    ASSERT_TRUE(Has(result.findings, Reason::kPointsWrong));
  }
  bool rejected = false;
  for (const PointRow& row : Table(done).rows)
    if (row.name == measured_.points[2].name) rejected = row.state == "rejected";
  EXPECT_TRUE(rejected);
}

TEST_F(PublishedPair, APhotoWithoutKnownPointsFailsByName) {
  if (!Read()) GTEST_SKIP() << "without the shared data";
  measured_.image_points.push_back(
      {"alone", "nowhere", std::nullopt, Eigen::Vector2d(1, 2), 0.005});
  const MeasuredBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 3u);
  EXPECT_EQ(done.results[2].photo, "alone");
  EXPECT_EQ(done.results[2].status, Status::kFailed);
  EXPECT_TRUE(Has(done.results[2].findings, Reason::kTooFewPoints));
  EXPECT_EQ(done.results[0].status, Status::kOk);
}

TEST_F(PublishedPair, FilmMeasuredInPixelsNeedsItsMarks) {
  measured_.folder = "said";
  measured_.image_points = {{"a", "p", Eigen::Vector2d(1, 2), std::nullopt, 1}};
  ExpectError<InputError>([&] { Adjusted(); }, {"said", "photo a", "marks.csv"});
  measured_.image_points.clear();
  ExpectError<InputError>([&] { Adjusted(); }, {"image_points.csv"});
}

}  // namespace
}  // namespace orient::block
