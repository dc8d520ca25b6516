#include "block/stages/point_start.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/geometry/collinearity.h"
#include "core/geometry/rotation.h"
#include "tests/support/made_up_patches.h"

namespace orient::block {
namespace {

constexpr double kPixel_mm = 0.1;
constexpr float kGround_m = 200;

Pose Truth() { return {{500000, 5000000, 1730}, {0.01, -0.02, 0.3}}; }

// A film photo with measured points, and a row of approximations as accurate as it says.
class PointStartOf : public testing::Test {
 protected:
  PointStartOf() {
    position_.photo_from_pixel = {kPixel_mm * PhotoFromPixelAxes(ScanOrientation::kR0),
                                  {-115, 115}};
    approximation_.pose = Truth();
    approximation_.pose.position_m += Eigen::Vector3d(8, -6, 4);
    approximation_.covariance.setZero();
    approximation_.covariance.diagonal() << 100, 100, 100, 1e-3, 1e-3, 1e-3;
  }

  PhotoView TrueView() const { return {camera_, position_.photo_from_pixel, Truth()}; }

  // Points of that sigma in one corner of the frame, wrong by so much to the east.
  void Measure(int count, double sigma_px, double sigma_m, PointRole role = PointRole::kControl,
               double wrong_m = 0) {
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at(-100 + 13 * (i % 3) + 2 * (i / 3), 90 - 15 * (i / 3));
      const Ray ray = GroundRayFromPhoto(camera_, Truth(), at).value();
      const double height_m = kGround_m + 30.0 * (i % 2);
      const Eigen::Vector3d ground_m =
          ray.origin_m + ray.direction * (height_m - ray.origin_m.z()) / ray.direction.z();
      const std::string name = "p" + std::to_string(measurements().points.size());
      measurements().points.push_back({name, ground_m + Eigen::Vector3d(wrong_m, 0, 0),
                                       Eigen::Vector3d::Constant(sigma_m), role});
      measurements().image_points.push_back(
          {"4711", name, *TrueView().PixelFromGround(ground_m), std::nullopt, sigma_px});
    }
  }

  PointStart Start(bool stated) {
    ScanInterior interior{{position_}, false, {}};
    return StartOf(setting_, "4711", approximation_, stated, &interior);
  }

  // What patches found: the truth, to a decimetre.
  ExteriorResult Found() const {
    ExteriorResult found;
    found.photo = "4711";
    found.status = Status::kOk;
    found.pose = Truth();
    found.covariance = Matrix6d::Zero();
    found.covariance->diagonal() << 0.01, 0.01, 0.01, 1e-9, 1e-9, 1e-9;
    return found;
  }
  bool Contradict(const PointStart& start) {
    return PointsContradict(setting_, Photo(), start, Found());
  }
  exterior::PhotoToOrient Photo() const {
    return {"4711", camera_, {position_}, approximation_, true, {}, &setting_.surface};
  }
  Measurements& measurements() { return options_.measurements; }

  static Camera FilmCamera() {
    Camera camera;
    camera.principal_distance_mm = 153;
    camera.frame_mm = {230, 230};
    return camera;
  }

  const Camera camera_ = FilmCamera();
  exterior::FilmPosition position_;
  PosePrior approximation_;
  ExteriorRunOptions options_;
  const ExteriorSetting setting_{
      options_,
      {FilmCamera(), {}, {}, {}, {}},
      0,
      {},
      {},
      MadeUpCrs(),
      GroundSurface::FromGrid(Eigen::MatrixXf::Constant(60, 60, kGround_m), 497000, 5003000, 100)};
};

// The same pose follows however the film lies on its scan.
TEST_F(PointStartOf, PointsMeasuredInThePhotoSystemLeaveOpenHowTheFilmLies) {
  Measure(8, 0.1, 0.05);
  for (ImagePointMeasurement& point : measurements().image_points) {
    point.photo_mm = position_.photo_from_pixel * *point.pixel;
    point.pixel.reset();
    point.sigma = 0.01;
  }
  exterior::FilmPosition turned;
  turned.photo_from_pixel = {kPixel_mm * PhotoFromPixelAxes(ScanOrientation::kR180), {115, -115}};
  turned.orientation = ScanOrientation::kR180;
  position_.orientation = ScanOrientation::kR0;
  ScanInterior interior{{turned, position_}, false, {}};
  const PointStart start = StartOf(setting_, "4711", approximation_, false, &interior);
  ASSERT_TRUE(start.by_points);
  EXPECT_LT((start.by_points->pose.position_m - Truth().position_m).norm(), 20);
  EXPECT_EQ(interior.positions.size(), 2u) << "the patches decide";
  exterior::PhotoToOrient photo = Photo();
  photo.positions = interior.positions;
  ExteriorResult result;
  OrientByPoints(setting_, photo, start, &result);
  EXPECT_EQ(result.status, Status::kWeak);
  EXPECT_TRUE(Has(result.findings, Reason::kOrientationOpen)) << JoinedSentences(result.findings);
}

TEST_F(PointStartOf, AgreeingPointsAndApproximationTogetherAreMorePreciseThanEither) {
  Measure(5, 20, 20);
  const PointStart start = Start(true);
  ASSERT_TRUE(start.by_points);
  EXPECT_TRUE(start.stated);
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(start.prior->covariance(i, i), approximation_.covariance(i, i)) << i;
    EXPECT_LT(start.prior->covariance(i, i), start.by_points->covariance(i, i)) << i;
  }
  EXPECT_LT((start.prior->pose.position_m - Truth().position_m).norm(), 20);
}

TEST_F(PointStartOf, AnAccuracyThatNobodyStatedIsNotStatedByPoints) {
  Measure(5, 20, 20);
  EXPECT_FALSE(Start(false).stated);
  measurements() = {};
  Measure(3, 1, 1);  // the approximation is in their pose
  EXPECT_FALSE(Start(false).stated);
}

TEST_F(PointStartOf, PointsThatContradictTheApproximationStartTheSearchAlone) {
  Measure(5, 1, 0.1);
  approximation_.pose.position_m.x() += 500;
  const PointStart start = Start(false);
  ASSERT_TRUE(start.by_points);
  EXPECT_EQ(start.prior->covariance, start.by_points->covariance);
  EXPECT_EQ(start.prior->pose.AsVector(), start.by_points->pose.AsVector());
  EXPECT_TRUE(start.stated) << "by whoever measured the points";
}

TEST_F(PointStartOf, AnApproximationThatIsInThePointsPoseIsNotCountedTwice) {
  Measure(3, 1, 1);
  const PointStart start = Start(true);
  ASSERT_TRUE(start.by_points);
  EXPECT_EQ(start.prior->covariance, start.by_points->covariance);
  EXPECT_TRUE(start.stated);
}

TEST_F(PointStartOf, MostControlPointsBesideAPoseContradictIt) {
  Measure(5, 1, 0.1);
  EXPECT_FALSE(Contradict(Start(true)));
  measurements() = {};
  Measure(5, 1, 0.1, PointRole::kControl, 60);
  EXPECT_TRUE(Contradict(Start(true)));
}

TEST_F(PointStartOf, CheckPointsDecideNothing) {
  Measure(5, 1, 0.1);
  Measure(7, 1, 0.1, PointRole::kCheck, 60);
  const PointStart start = Start(true);
  EXPECT_FALSE(Contradict(start));
  ExteriorResult found = Found();
  CompareWithPoints(setting_, Photo(), start, &found);
  EXPECT_TRUE(Has(found.findings, Reason::kPointsOffPose)) << "they are compared";

  measurements() = {};
  Measure(5, 1, 0.1, PointRole::kControl, 60);
  Measure(7, 1, 0.1, PointRole::kCheck);
  EXPECT_TRUE(Contradict(Start(true)));
}

TEST_F(PointStartOf, PointsThatTheOthersShowToBeWrongHaveNoVote) {
  Measure(6, 1, 0.1);
  for (const std::size_t i : {1, 4}) measurements().points[i].ground_m.y() += 300;
  PointStart start = Start(true);
  ASSERT_TRUE(start.by_points);
  EXPECT_EQ(start.by_points->Used(), 4);
  for (std::size_t i = 0; i < 2; ++i) measurements().points[2 + i].ground_m.x() += 60;
  EXPECT_FALSE(Contradict(start)) << "two of the four used";
}

// What was found without them, and they do not contradict, did not begin with them.
TEST_F(PointStartOf, PointsThatDidNotBeginTheSearchAreNotSaidToHaveDoneSo) {
  Measure(5, 1, 0.1);
  PointStart start = Start(true);
  ExteriorResult found = Found();
  CompareWithPoints(setting_, Photo(), start, &found);
  EXPECT_TRUE(Has(found.findings, Reason::kStartedByPoints));
  start.by_points_began = false;
  found = Found();
  CompareWithPoints(setting_, Photo(), start, &found);
  EXPECT_TRUE(found.findings.empty()) << JoinedSentences(found.findings);
  for (const OverviewItem& item : ClickedPoints(start)) EXPECT_EQ(item.state, OverviewState::kUsed);
}

}  // namespace
}  // namespace orient::block
