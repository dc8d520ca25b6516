#include "block/stages/measured_block.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <tuple>

#include "block/verdict/point_table.h"
#include "core/base/error.h"
#include "core/base/table_text.h"
#include "core/geometry/collinearity.h"
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
  JudgedBlock Adjusted() const { return AdjustMeasurements({camera_, measured_}); }
  PointTable Table(const JudgedBlock& done) const {
    return TableOfPoints(done.adjusted.surveyed, done.adjusted.block, done.adjusted.result);
  }

  CameraFile camera_;
  Measurements measured_;
  std::map<std::string, std::pair<double, double>> published_;  // value, precision
};

TEST_F(PublishedPair, IsAdjustedFromItsImageMeasurementsAlone) {
  if (!Read()) GTEST_SKIP() << "without the shared data";
  const JudgedBlock done = Adjusted();
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
  const JudgedBlock done = Adjusted();
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
  const JudgedBlock done = Adjusted();
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

// A simple camera over flat ground, measured in pixels, so that marks come in.
class FilmInPixels : public testing::Test {
 protected:
  FilmInPixels() {
    camera_.camera.kind = CameraKind::kFilm;
    camera_.camera.principal_distance_mm = 150;
    camera_.camera.frame_mm = {200, 200};
    for (const auto& [id, x, y] : {std::tuple("1", -90, 90), std::tuple("2", 90, 90),
                                   std::tuple("3", 90, -90), std::tuple("4", -90, -90)})
      camera_.fiducials.push_back({id, Eigen::Vector2d(x, y), "mark", {}});
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j)
        measured_.points.push_back({"p" + std::to_string(5 * i + j),
                                    {200.0 * i, 180.0 * j, 100.0 + 7 * ((3 * i + j) % 5)},
                                    Eigen::Vector3d::Constant(0.02),
                                    PointRole::kControl});
    See("a", {{300, 350, 1100}, {0.01, -0.02, 0.1}}, 0.2);
    See("b", {{500, 350, 1120}, {-0.01, 0.01, 0.05}}, 0.2);
  }

  // Pixels of 0.02 mm.
  void See(const std::string& photo, const Pose& pose, double sigma_px) {
    const auto pixel = [](const Eigen::Vector2d& mm) {
      return Eigen::Vector2d(5000 + mm.x() / 0.02, 5000 - mm.y() / 0.02);
    };
    for (const Fiducial& mark : camera_.fiducials)
      measured_.marks.push_back({photo, mark.id, pixel(mark.position_mm), 0.1, false, {}});
    for (const GroundPoint& point : measured_.points)
      if (const auto mm = PhotoFromGround(camera_.camera, pose, point.ground_m))
        measured_.image_points.push_back(
            {photo, point.name, pixel(*mm), std::nullopt, sigma_px, {}});
  }
  JudgedBlock Adjusted() const { return AdjustMeasurements({camera_, measured_}); }

  CameraFile camera_;
  Measurements measured_;
};

TEST_F(FilmInPixels, IsOkWhereItIsPrecise) {
  const JudgedBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 2u);
  for (const ExteriorResult& result : done.results) {
    EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
    EXPECT_LT(result.projection_sigma->px, 0.5);
  }
}

TEST_F(FilmInPixels, IsWeakWhereItIsNotAndTheTargetDecides) {
  for (ImagePointMeasurement& point : measured_.image_points) point.sigma = 30;
  MeasuredBlockInputs inputs{camera_, measured_};
  for (const ExteriorResult& result : AdjustMeasurements(inputs).results) {
    EXPECT_EQ(result.status, Status::kWeak);
    EXPECT_TRUE(Has(result.findings, Reason::kPoorlyDetermined));
  }
  inputs.target_m = 50;
  for (const ExteriorResult& result : AdjustMeasurements(inputs).results)
    EXPECT_EQ(result.status, Status::kOk);
}

TEST_F(FilmInPixels, IsWeakWhereNoPointChecksTheOthers) {
  // Four in the corners: precise, but an error of one of them hardly shows.
  for (ImagePointMeasurement& point : measured_.image_points) point.sigma = 0.05;
  const auto in_a = [](const ImagePointMeasurement& one) { return one.photo == "a"; };
  std::erase_if(measured_.image_points, [&](const ImagePointMeasurement& one) {
    const bool corner =
        one.point == "p0" || one.point == "p3" || one.point == "p10" || one.point == "p13";
    return in_a(one) && !corner;
  });
  const JudgedBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 2u);
  ASSERT_TRUE(done.results[0].pose) << JoinedSentences(done.results[0].findings);
  EXPECT_EQ(done.results[0].status, Status::kWeak);
  EXPECT_TRUE(Has(done.results[0].findings, Reason::kByPointsAlone))
      << JoinedSentences(done.results[0].findings);
  EXPECT_EQ(done.results[1].status, Status::kOk) << JoinedSentences(done.results[1].findings);
}

// Files of results have the transform of the clicked marks, not the adjusted one.
TEST_F(FilmInPixels, ThePoseHoldsWithTheTransformOfTheMarksAsClicked) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal(0, 2);
  for (MarkMeasurement& mark : measured_.marks) {
    mark.pixel += Eigen::Vector2d(normal(random), normal(random));
    mark.sigma_px = 2;
  }
  const JudgedBlock done = Adjusted();
  std::vector<PointPair2d> pairs;
  for (const MarkMeasurement& mark : measured_.marks)
    for (const Fiducial& fiducial : camera_.fiducials)
      if (mark.photo == "a" && fiducial.id == mark.mark)
        pairs.push_back({mark.pixel, fiducial.position_mm});
  const Affine2d by_marks = FitAffine(pairs).value().transform;
  ASSERT_TRUE(done.results[0].pose);
  const PhotoView view{camera_.camera, by_marks, *done.results[0].pose};
  double sum = 0;
  int seen = 0;
  for (const ImagePointMeasurement& point : measured_.image_points) {
    if (point.photo != "a") continue;
    sum += (*point.pixel - *view.PixelFromGround(measured_.Point(point.point)->ground_m))
               .squaredNorm();
    ++seen;
  }
  EXPECT_LT(std::sqrt(sum / seen), 1.2) << "a pose takes up the most of it";
}

// In one of a hundred photos the residuals of four marks are ten times too small by chance; those
// of this test's marks are nothing.
TEST_F(FilmInPixels, FourMarksThatFitByChanceAreNotBelieved) {
  const BlockPhoto photo = Adjusted().adjusted.block.photos.at(0);
  Eigen::Matrix<double, 2, 6> by_film = Eigen::Matrix<double, 2, 6>::Zero();
  by_film.block<1, 2>(0, 0) = by_film.block<1, 2>(1, 2) = Eigen::RowVector2d(5000, 5000);
  by_film.rightCols<2>().setIdentity();
  const Eigen::Matrix2d middle = by_film * photo.interior * by_film.transpose();
  EXPECT_GT(std::sqrt(middle(0, 0)), 0.0008) << "four clicks of 2 um on film of 3 um";
  EXPECT_LT(std::sqrt(middle(0, 0)), 0.004);
}

TEST_F(FilmInPixels, ConfusedMarksFailTheirPhotoAlone) {
  std::swap(measured_.marks[0].mark, measured_.marks[1].mark);
  const JudgedBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 2u);
  EXPECT_EQ(done.results[0].status, Status::kFailed);
  ASSERT_TRUE(Has(done.results[0].findings, Reason::kMeasuredMarksContradict));
  EXPECT_NE(done.results[0].findings[0].where.find("2 ("), std::string::npos);
  EXPECT_EQ(done.results[1].status, Status::kOk);
}

TEST_F(FilmInPixels, ARejectedPhotoTakesNoPart) {
  const double both = Adjusted().adjusted.result.redundancy;
  measured_.decisions.push_back({"a", DecisionKind::kReject, "", "clouds", {}});
  const JudgedBlock done = Adjusted();
  ASSERT_EQ(done.results.size(), 2u);
  EXPECT_EQ(done.results[0].photo, "a");
  EXPECT_EQ(done.results[0].status, Status::kFailed);
  EXPECT_EQ(done.results[1].status, Status::kOk);
  EXPECT_EQ(done.adjusted.block.photos.size(), 1u);
  EXPECT_LT(done.adjusted.result.redundancy, both);
}

TEST_F(FilmInPixels, ACheckPointClickedElsewhereIsNamed) {
  for (std::size_t i = 0; i < measured_.points.size(); i += 3)
    measured_.points[i].role = PointRole::kCheck;
  std::mt19937 random(1);
  std::normal_distribution<double> normal(0, 0.2);
  for (ImagePointMeasurement& point : measured_.image_points)
    *point.pixel += Eigen::Vector2d(normal(random), normal(random));
  const auto said = [&] {
    const JudgedBlock done = Adjusted();
    return TextOf(TableOfPoints(done.adjusted.surveyed, done.adjusted.block, done.adjusted.result));
  };
  for (const std::string& line : said()) EXPECT_EQ(line.find("far off"), std::string::npos);
  for (const ExteriorResult& result : Adjusted().results)
    EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  for (ImagePointMeasurement& point : measured_.image_points)
    if (point.point == "p12" && point.photo == "a") point.pixel->x() += 80;
  const std::vector<std::string> lines = said();
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.back().find("far off p12"), 0u) << lines.back();
}

}  // namespace
}  // namespace orient::block
