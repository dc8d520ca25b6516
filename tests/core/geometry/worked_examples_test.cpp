// Examples of textbooks and courses, and a real block, against what their authors printed.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <fstream>
#include <map>
#include <sstream>

#include "core/geometry/collinearity.h"
#include "core/geometry/intersection.h"
#include "core/geometry/resection.h"
#include "core/geometry/transform2d.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

// The rows of a table without its header; blanks and commas both part.
std::vector<std::vector<std::string>> Rows(const std::string& path, bool header) {
  std::ifstream file(path);
  std::vector<std::vector<std::string>> rows;
  std::string line;
  if (header) std::getline(file, line);
  while (std::getline(file, line)) {
    for (char& c : line)
      if (c == ',') c = ' ';
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; words >> word;) row.push_back(word);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

double Number(const std::string& text) { return std::stod(text); }

// What the authors printed, with half of the last printed digit as the tolerance.
class Printed {
 public:
  Printed(const std::string& folder, const std::string& example) {
    for (const auto& row : Rows(folder + "/expected.csv", true))
      if (row[0] == example) values_[row[1]] = row[2];
  }
  void Expect(const std::string& quantity, double value) const {
    const std::string& text = values_.at(quantity);
    const auto exponent = text.find_first_of("eE");
    const auto point = text.find('.');
    const auto digits = (exponent == std::string::npos ? text.size() : exponent) - point - 1;
    const double power = exponent == std::string::npos ? 0 : Number(text.substr(exponent + 1));
    const double half = 0.5 * std::pow(10, power - static_cast<double>(digits));
    EXPECT_NEAR(value, Number(text), half * 1.0000001) << quantity;
  }
  double Value(const std::string& quantity) const { return Number(values_.at(quantity)); }

 private:
  std::map<std::string, std::string> values_;
};

std::vector<ControlObservation> ReadPoints(const std::string& path) {
  std::vector<ControlObservation> points;
  for (const auto& row : Rows(path, false)) {
    ControlObservation p;
    p.photo_mm = {Number(row[1]), Number(row[2])};
    p.ground_m = {Number(row[3]), Number(row[4]), Number(row[5])};
    points.push_back(p);
  }
  return points;
}

TEST(WorkedExamples, ResectionOfMikhailBethelMcGlone) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection");
  const Printed printed(folder, "mikhail");
  Camera camera;
  camera.principal_distance_mm = 152.222;
  const Pose start = {{914250, 575400, 800}, {0, 0, -1.57}};
  const auto result = Resect(camera, ReadPoints(folder + "/mikhail_points.txt"), start);
  ASSERT_TRUE(result);
  printed.Expect("omega", result->pose.opk_rad[0]);
  printed.Expect("phi", result->pose.opk_rad[1]);
  printed.Expect("kappa", result->pose.opk_rad[2]);
  printed.Expect("x", result->pose.position_m.x());
  printed.Expect("y", result->pose.position_m.y());
  printed.Expect("z", result->pose.position_m.z());
  double sum = 0;
  for (const auto& v : result->residuals_mm) sum += v.squaredNorm();
  printed.Expect("sum_of_squared_residuals", sum);
}

TEST(WorkedExamples, ResectionOfTheCourseStartsFromThreePoints) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection");
  const Printed printed(folder, "engo431_resection");
  Camera camera;
  camera.principal_distance_mm = printed.Value("principal_distance");
  const auto points = ReadPoints(folder + "/engo431_resection_points.txt");
  const auto starts = ResectThreePoints(camera, {points[0], points[1], points[2]});
  ASSERT_FALSE(starts.empty());
  for (const Pose& start : starts) {
    const auto result = Resect(camera, points, start);
    ASSERT_TRUE(result);
    printed.Expect("x", result->pose.position_m.x());
    printed.Expect("y", result->pose.position_m.y());
    printed.Expect("z", result->pose.position_m.z());
    printed.Expect("omega", DegFromRad(result->pose.opk_rad[0]));
    printed.Expect("phi", DegFromRad(result->pose.opk_rad[1]));
    printed.Expect("kappa", DegFromRad(result->pose.opk_rad[2]));
  }
}

struct Pair {
  Camera camera;
  Pose left, right;
  std::map<std::string, std::vector<PhotoObservation>> points;

  explicit Pair(const std::string& folder) {
    camera.principal_distance_mm = 152.15;
    Vector6d l, r;
    int element = 0;
    for (const auto& row : Rows(folder + "/engo431_intersection.txt", false)) {
      if (row.size() == 5 && element == 0 && row[0] != "FORMAT:")
        points[row[0]] = {{&camera, {}, {Number(row[1]), Number(row[2])}},
                          {&camera, {}, {Number(row[3]), Number(row[4])}}};
      if (row.size() == 4 && row[0].size() <= 2 && element < 6) {
        l[element] = Number(row[2]);
        r[element++] = Number(row[3]);
      }
      if (row.size() == 4 && row[1] == "(dd)") {
        l[element - 1] = RadFromDeg(l[element - 1]);
        r[element - 1] = RadFromDeg(r[element - 1]);
      }
    }
    left = Pose::FromVector(l);
    right = Pose::FromVector(r);
    for (auto& [name, photos] : points) {
      photos[0].pose = left;
      photos[1].pose = right;
    }
  }
  Pair(const Pair&) = delete;
};

// The course's way: the collinearity equations made linear in the point, x W + c U = 0.
Eigen::Vector3d LinearPoint(const std::vector<PhotoObservation>& photos) {
  Eigen::Matrix<double, 4, 3> a;
  Eigen::Vector4d b;
  for (int i = 0; i < 4; ++i) {
    const PhotoObservation& photo = photos[static_cast<std::size_t>(i / 2)];
    const Eigen::Matrix3d m = photo.pose.GroundFromPhoto().transpose();
    a.row(i) =
        photo.photo_mm[i % 2] * m.row(2) + photo.camera->principal_distance_mm * m.row(i % 2);
    b[i] = a.row(i).dot(photo.pose.position_m);
  }
  return a.colPivHouseholderQr().solve(b);
}

// One Gauss-Newton step with the sign of dy/dX turned round.
Eigen::Vector3d StepWithWrongSign(const std::vector<PhotoObservation>& photos,
                                  const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 4, 3> a;
  Eigen::Vector4d w;
  for (int i = 0; i < 2; ++i) {
    const PhotoObservation& photo = photos[static_cast<std::size_t>(i)];
    const auto d = PhotoFromGroundWithDerivatives(*photo.camera, photo.pose, point).value();
    a.row(2 * i) = d.by_ground.row(0);
    a.row(2 * i + 1) = -d.by_ground.row(1);
    w.segment<2>(2 * i) = photo.photo_mm - d.photo_mm;
  }
  return point + a.colPivHouseholderQr().solve(w);
}

TEST(WorkedExamples, IntersectionOfTheCourse) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection");
  const Printed printed(folder, "engo431_intersection");
  const Pair pair(folder);
  ASSERT_EQ(pair.points.size(), 2u);
  for (const auto& [name, photos] : pair.points) {
    // The printed points are not the least-squares ones. They come out to all digits as a single
    // step from the linear solution with the derivatives of y taken with the wrong sign; our
    // derivatives and the linear solution are thereby held to all printed digits.
    const Eigen::Vector3d as_printed = StepWithWrongSign(photos, LinearPoint(photos));
    printed.Expect(name + "_x", as_printed.x());
    printed.Expect(name + "_y", as_printed.y());
    printed.Expect(name + "_z", as_printed.z());

    const auto result = IntersectPhotos(photos);
    ASSERT_TRUE(result);
    EXPECT_LT((result->ground_m - as_printed).norm(), 0.005);
    double ours = 0, theirs = 0;
    for (std::size_t i = 0; i < 2; ++i) {
      ours += result->residuals_mm[i].squaredNorm();
      theirs +=
          (photos[i].photo_mm - PhotoFromGround(pair.camera, photos[i].pose, as_printed).value())
              .squaredNorm();
    }
    EXPECT_LT(ours, theirs);
  }
}

TEST(WorkedExamples, FiducialsOfTheCourseLieWithinScannerAccuracyOfAnAffine) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection");
  const auto measured = Rows(folder + "/engo431_fiducials_measured_px.csv", true);
  const auto calibrated = Rows(folder + "/engo431_fiducials_calibrated_mm.csv", true);
  ASSERT_EQ(measured.size(), 8u);
  for (const std::size_t photo : {1u, 3u}) {
    std::vector<PointPair2d> pairs;
    for (std::size_t i = 0; i < 8; ++i)
      pairs.push_back({{Number(measured[i][photo]), Number(measured[i][photo + 1])},
                       {Number(calibrated[i][1]), Number(calibrated[i][2])}});
    const auto fit = FitAffine(pairs);
    ASSERT_TRUE(fit);
    EXPECT_EQ(fit->redundancy, 10);
    EXPECT_LT(fit->sigma0, 0.012);  // the scan's pixel is 0.0119 mm
    EXPECT_NEAR(fit->transform.A(0, 0), 0.0119, 1e-5);
    EXPECT_NEAR(fit->transform.A(1, 1), 0.0119, 1e-5);  // rows counted negative downwards
  }
}

TEST(WorkedExamples, FiducialsOfTheRc30) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection/rc30_pair");
  for (const char* name : {"/fiducials_62.csv", "/fiducials_63.csv"}) {
    std::vector<PointPair2d> pairs;
    for (const auto& row : Rows(folder + name, true))
      // The table counts rows negative downwards; a pixel's row runs down.
      pairs.push_back({{Number(row[1]), -Number(row[2])}, {Number(row[3]), Number(row[4])}});
    ASSERT_EQ(pairs.size(), 8u);
    const auto fit = FitAffine(pairs);
    ASSERT_TRUE(fit);
    EXPECT_LT(fit->sigma0, 0.005);
    EXPECT_EQ(NearestScanOrientation(fit->transform), ScanOrientation::kR0);
    EXPECT_NEAR(std::sqrt(-fit->transform.A.determinant()), 0.015, 1e-4);
  }
}

TEST(WorkedExamples, ResectionsOfTheRc30PairAgreeWithItsPublishedBlock) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection/rc30_pair");
  Camera camera;
  camera.principal_distance_mm = 154.006;
  std::map<std::string, Eigen::Vector3d> control;
  for (const auto& row : Rows(folder + "/control.csv", true))
    control[row[0]] = {Number(row[1]), Number(row[2]), Number(row[3])};
  std::map<std::string, std::pair<double, double>> published;
  for (const auto& row : Rows(folder + "/published_result.csv", true))
    published[row[0]] = {Number(row[1]), Number(row[2])};
  for (const std::string photo : {"P62", "P63"}) {
    std::vector<ControlObservation> observations;
    for (const auto& row : Rows(folder + "/block_observations.csv", true)) {
      if (row[0] != photo || !control.count(row[1])) continue;
      ControlObservation o;
      o.ground_m = control[row[1]];
      o.photo_mm = {Number(row[2]), Number(row[3])};
      observations.push_back(o);
    }
    ASSERT_EQ(observations.size(), 6u);
    const auto starts =
        ResectThreePoints(camera, {observations[0], observations[2], observations[5]});
    ASSERT_FALSE(starts.empty());
    std::optional<ResectionResult> result;
    for (const Pose& start : starts)
      if (auto adjusted = Resect(camera, observations, start))
        if (!result || adjusted->sigma0 < result->sigma0) result = adjusted;
    ASSERT_TRUE(result);
    const Vector6d v = result->pose.AsVector();
    const char* const element[] = {"X", "Y", "Z", "O", "P", "K"};
    for (int i = 0; i < 6; ++i) {
      const auto [value, precision] = published.at(photo + "_15_" + element[i]);
      const double ours = i < 3 ? v[i] : DegFromRad(v[i]);
      const double sigma = i < 3 ? precision : precision / 3600;
      // The block used tie points besides, a single photo has its control only.
      EXPECT_NEAR(ours, value, 1.5 * sigma) << photo << " " << element[i];
    }
  }
}

TEST(WorkedExamples, TiePointsOfTheRc30PairLieWhereThePublishedBlockHasThem) {
  ORIENT_REQUIRE_SHARED_DATA(folder, "resection/rc30_pair");
  Camera camera;
  camera.principal_distance_mm = 154.006;
  std::map<std::string, Vector6d> poses;
  std::map<std::string, Eigen::Vector3d> ties, sigmas;
  for (const auto& row : Rows(folder + "/published_result.csv", true)) {
    const std::string name = row[0].substr(0, row[0].find('_'));
    const auto axis = static_cast<int>(std::string("XYZOPK").find(row[0].back()));
    if (name[0] == 'P') poses[name][axis] = axis < 3 ? Number(row[1]) : RadFromDeg(Number(row[1]));
    if (name[0] == 't') ties[name][axis] = Number(row[1]);
    if (name[0] == 't') sigmas[name][axis] = Number(row[2]);
  }
  std::map<std::string, std::vector<PhotoObservation>> observations;
  for (const auto& row : Rows(folder + "/block_observations.csv", true))
    observations[row[1]].push_back(
        {&camera, Pose::FromVector(poses[row[0]]), {Number(row[2]), Number(row[3])}});
  ASSERT_EQ(ties.size(), 6u);
  for (const auto& [name, published] : ties) {
    const auto result = IntersectPhotos(observations[name]);
    ASSERT_TRUE(result);
    for (int i = 0; i < 3; ++i)
      EXPECT_NEAR(result->ground_m[i], published[i], sigmas[name][i]) << name << " " << i;
  }
}

}  // namespace
}  // namespace orient
