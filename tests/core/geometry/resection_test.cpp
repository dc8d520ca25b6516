#include "core/geometry/resection.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/geometry/collinearity.h"
#include "tests/support/generators.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kReproduced_mm = 1e-9;

Camera Film() {
  Camera camera;
  camera.principal_distance_mm = 153.0;
  camera.principal_point_mm = {0.01, -0.02};
  camera.frame_mm = {230, 230};
  camera.lens = BrownDistortion{{2e-8, -1e-12, 0}, {1e-7, 2e-7}};
  return camera;
}

Pose Truth() { return {{612345.6, 5123456.7, 1843.2}, {0.021, -0.034, 2.2}}; }

// Ground points under the pose, spread over the frame, with 100 m of relief.
std::vector<ControlObservation> Exact(const Camera& camera, const Pose& pose, int count,
                                      unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-105, 105), height(100, 200);
  std::vector<ControlObservation> observations;
  for (int i = 0; i < count; ++i) {
    const Ray ray = GroundRayFromPhoto(camera, pose, {place(random), place(random)}).value();
    ControlObservation o;
    o.ground_m =
        ray.origin_m + ray.direction * (height(random) - ray.origin_m.z()) / ray.direction.z();
    o.photo_mm = PhotoFromGround(camera, pose, o.ground_m).value();
    observations.push_back(o);
  }
  return observations;
}

Pose Disturbed(const Pose& pose, double metres, double radians) {
  Vector6d v = pose.AsVector();
  v.head<3>() += metres * Eigen::Vector3d(1, -1, 0.5);
  v.tail<3>() += radians * Eigen::Vector3d(-1, 1, 1);
  return Pose::FromVector(v);
}

Vector6d Error(const Pose& pose, const Pose& truth) {
  Vector6d error = pose.AsVector() - truth.AsVector();
  for (int i = 3; i < 6; ++i) error[i] = NormalizeAngle(error[i]);
  return error;
}

void AddNoise(std::vector<ControlObservation>* observations, std::mt19937* random) {
  std::normal_distribution<double> noise;
  for (ControlObservation& o : *observations) {
    const Eigen::Matrix2d l = o.covariance_mm2.llt().matrixL();
    o.photo_mm += l * Eigen::Vector2d(noise(*random), noise(*random));
  }
}

// ---- three points ------------------------------------------------------------------------------

void ExpectReproduced(const Camera& camera, const std::vector<Pose>& poses,
                      const std::array<ControlObservation, 3>& observations) {
  RC_ASSERT(poses.size() <= 4);
  for (const Pose& pose : poses)
    for (const ControlObservation& o : observations) {
      const auto photo = PhotoFromGround(camera, pose, o.ground_m);
      RC_ASSERT(photo.has_value());
      // Ground coordinates of 5e6 m carry 1e-9 m, larger in the photo the closer the camera is.
      const double rounding_mm =
          1e-8 * camera.principal_distance_mm / (o.ground_m - pose.position_m).norm();
      RC_ASSERT((*photo - o.photo_mm).norm() < kReproduced_mm + rounding_mm);
    }
}

TEST(ResectThreePoints, OneOfAtMostFourPosesIsTheTruthAndAllReproduceTheImagePoints) {
  int found = 0, tried = 0;
  EXPECT_TRUE(rc::check("three points", [&] {
    const Camera camera = Film();
    Pose truth;
    truth.position_m = {*InRange(4e5, 6e5), *InRange(4e6, 6e6), *InRange(1500, 3000)};
    truth.opk_rad = {*InRange(-0.3, 0.3), *InRange(-0.3, 0.3), *InRange(-3.1, 3.1)};
    const auto points = Exact(camera, truth, 3, *rc::gen::inRange(1u, 100000u));
    const std::array<ControlObservation, 3> three = {points[0], points[1], points[2]};
    const auto poses = ResectThreePoints(camera, three);
    ExpectReproduced(camera, poses, three);
    ++tried;
    for (const Pose& pose : poses)
      if ((pose.position_m - truth.position_m).norm() < 1e-2) {
        ++found;
        break;
      }
  }));
  EXPECT_GE(found, tried - 1);  // one of a hundred may lie on the danger cylinder
}

TEST(ResectThreePoints, FindsFourPosesWhereThereAreFour) {
  // An equilateral triangle seen from straight above its centre: the pose itself and three others.
  Camera camera;
  camera.principal_distance_mm = 150;
  const Pose truth = {{1000, 2000, 1500}, {0, 0, 0}};
  std::array<ControlObservation, 3> three;
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = 2.0 * static_cast<double>(i) * std::acos(-1.0) / 3 + 0.3;
    three[i].ground_m = {1000 + 900 * std::cos(angle), 2000 + 900 * std::sin(angle), 0};
    three[i].photo_mm = PhotoFromGround(camera, truth, three[i].ground_m).value();
  }
  const auto poses = ResectThreePoints(camera, three);
  EXPECT_EQ(poses.size(), 4u);
  double nearest = 1e9;
  for (const Pose& pose : poses)
    nearest = std::min(nearest, (pose.position_m - truth.position_m).norm());
  EXPECT_LT(nearest, 1e-6);
}

TEST(ResectThreePoints, OnTheDangerCylinderTheDoubleRootIsFound) {
  // The projection centre lies on the upright cylinder through the three points: two solutions
  // coincide there, and a nearby pose cannot be told from the truth by the images.
  Camera camera;
  camera.principal_distance_mm = 150;
  const Pose truth = {{500, 0, 1000}, {0.02, -0.01, 0.4}};
  std::array<ControlObservation, 3> three;
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = 2.0 + 1.1 * static_cast<double>(i);
    three[i].ground_m = {500 * std::cos(angle), 500 * std::sin(angle), 0};
    three[i].photo_mm = PhotoFromGround(camera, truth, three[i].ground_m).value();
  }
  const auto poses = ResectThreePoints(camera, three);
  ExpectReproduced(camera, poses, three);
  double nearest = 1e9;
  for (const Pose& pose : poses)
    nearest = std::min(nearest, (pose.position_m - truth.position_m).norm());
  EXPECT_LT(nearest, 0.1);  // a double root is known to the square root of the arithmetic
}

TEST(ResectThreePoints, CollinearAndCoincidentGroundPointsHaveNoPose) {
  Camera camera;
  camera.principal_distance_mm = 150;
  std::array<ControlObservation, 3> three;
  for (std::size_t i = 0; i < 3; ++i) {
    three[i].ground_m = {100.0 * static_cast<double>(i), 50.0 * static_cast<double>(i), 0};
    three[i].photo_mm = {10.0 * static_cast<double>(i), 5.0 * static_cast<double>(i)};
  }
  EXPECT_TRUE(ResectThreePoints(camera, three).empty());
  three[2] = three[1];
  EXPECT_TRUE(ResectThreePoints(camera, three).empty());
}

TEST(ResectThreePoints, CoincidentImagePointsAreNoCrash) {
  Camera camera;
  camera.principal_distance_mm = 150;
  std::array<ControlObservation, 3> three;
  three[0].ground_m = {0, 0, 0};
  three[1].ground_m = {100, 0, 0};
  three[2].ground_m = {0, 100, 0};
  for (auto& o : three) o.photo_mm = {3, 3};
  EXPECT_TRUE(ResectThreePoints(camera, three).empty());
}

// ---- adjustment --------------------------------------------------------------------------------

TEST(Resect, ExactObservationsGiveTheExactPoseFromFarAway) {
  const auto result =
      Resect(Film(), Exact(Film(), Truth(), 8, TestSeed()), Disturbed(Truth(), 150, RadFromDeg(5)));
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->converged);
  EXPECT_LT(Error(result->pose, Truth()).head<3>().norm(), 1e-6);
  EXPECT_LT(Error(result->pose, Truth()).tail<3>().norm(), 1e-9);
  EXPECT_LT(result->sigma0, 1e-6);
  EXPECT_EQ(result->degrees_of_freedom, 10);
}

TEST(Resect, KappaMayTurnThroughTheHalfTurn) {
  Pose truth = Truth();
  truth.opk_rad[2] = RadFromDeg(179.9);
  Pose start = truth;
  start.opk_rad[2] = RadFromDeg(-179.0);
  const auto result = Resect(Film(), Exact(Film(), truth, 6, TestSeed()), start);
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->pose.opk_rad[2], truth.opk_rad[2], 1e-9);
  // And the same where the prior names the same kappa a whole turn lower.
  Pose prior = truth;
  prior.opk_rad[2] -= RadFromDeg(360);
  ResectionOptions options;
  options.prior = PosePrior{prior, 1e-8 * Matrix6d::Identity()};
  const auto with_prior = Resect(Film(), Exact(Film(), truth, 6, TestSeed()), truth, options);
  ASSERT_TRUE(with_prior);
  EXPECT_NEAR(with_prior->pose.opk_rad[2], truth.opk_rad[2], 1e-9);
}

TEST(Resect, CovarianceIsTheScatterOfManyAdjustments) {
  std::mt19937 random(TestSeed());
  auto exact = Exact(Film(), Truth(), 10, TestSeed());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    exact[i].covariance_mm2 << 1e-4, 5e-5, 5e-5, 4e-4;
    if (i % 2 == 0) exact[i].covariance_mm2 *= 9;
  }
  double sum = 0, sigma0_sum = 0;
  Vector6d squares = Vector6d::Zero();
  constexpr int kRuns = 500;
  std::optional<ResectionResult> result;
  for (int run = 0; run < kRuns; ++run) {
    auto noisy = exact;
    AddNoise(&noisy, &random);
    result = Resect(Film(), noisy, Disturbed(Truth(), 20, 0.01));
    ASSERT_TRUE(result);
    const Vector6d error = Error(result->pose, Truth());
    sum += error.dot(result->covariance.ldlt().solve(error)) / 6;
    squares += error.cwiseProduct(error).cwiseQuotient(result->covariance.diagonal());
    sigma0_sum += result->sigma0 * result->sigma0;
  }
  EXPECT_NEAR(std::sqrt(sum / kRuns), 1.0, 0.05);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(squares[i] / kRuns), 1.0, 0.12) << i;
  EXPECT_NEAR(std::sqrt(sigma0_sum / kRuns), 1.0, 0.05);
}

TEST(Resect, ThePriorPullsWithItsWeight) {
  // The error of pose against truth, with observations and a prior both drawn at random, is normal
  // with the covariance that the adjustment says.
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> noise;
  const auto exact = Exact(Film(), Truth(), 4, TestSeed());
  Vector6d sigma;
  sigma << 0.2, 0.2, 0.1, 1e-4, 1e-4, 1e-4;
  double sum = 0;
  constexpr int kRuns = 400;
  for (int run = 0; run < kRuns; ++run) {
    auto noisy = exact;
    AddNoise(&noisy, &random);
    Vector6d prior = Truth().AsVector();
    for (int i = 0; i < 6; ++i) prior[i] += sigma[i] * noise(random);
    ResectionOptions options;
    options.prior = PosePrior{Pose::FromVector(prior), sigma.cwiseAbs2().asDiagonal()};
    const auto result = Resect(Film(), noisy, Pose::FromVector(prior), options);
    ASSERT_TRUE(result);
    EXPECT_EQ(result->degrees_of_freedom, 8);
    const Vector6d error = Error(result->pose, Truth());
    sum += error.dot(result->covariance.ldlt().solve(error)) / 6;
  }
  EXPECT_NEAR(std::sqrt(sum / kRuns), 1.0, 0.06);
}

TEST(Resect, APriorAloneComesBackAsItIs) {
  ResectionOptions options;
  Vector6d variance;
  variance << 4, 9, 16, 1e-4, 2e-4, 3e-4;
  options.prior = PosePrior{Truth(), variance.asDiagonal()};
  const auto result = Resect(Film(), {}, Disturbed(Truth(), 10, 0.01), options);
  ASSERT_TRUE(result);
  EXPECT_LT(Error(result->pose, Truth()).norm(), 1e-6);
  EXPECT_LT((result->covariance.diagonal() - variance).cwiseQuotient(variance).norm(), 1e-9);
  EXPECT_EQ(result->degrees_of_freedom, 0);
}

TEST(Resect, RedundancyNumbersAddUpToTheDegreesOfFreedom) {
  const auto result = Resect(Film(), Exact(Film(), Truth(), 7, TestSeed()), Truth());
  ASSERT_TRUE(result);
  EXPECT_NEAR(std::accumulate(result->redundancy.begin(), result->redundancy.end(), 0.0), 8, 1e-9);
  for (const double r : result->redundancy) {
    EXPECT_GE(r, 0);
    EXPECT_LE(r, 2);
  }
  const auto minimal = Resect(Film(), Exact(Film(), Truth(), 3, TestSeed()), Truth());
  ASSERT_TRUE(minimal);
  EXPECT_EQ(minimal->degrees_of_freedom, 0);
  EXPECT_EQ(minimal->sigma0, 0);
  for (const double r : minimal->redundancy) EXPECT_NEAR(r, 0, 1e-6);
}

TEST(Resect, ResidualIsMeasuredMinusComputed) {
  auto observations = Exact(Film(), Truth(), 60, TestSeed());
  observations[7].photo_mm.x() += 0.1;
  const auto result = Resect(Film(), observations, Truth());
  ASSERT_TRUE(result);
  EXPECT_GT(result->residuals_mm[7].x(), 0.07);
}

TEST(Resect, ACauchyLossForgetsBlunders) {
  std::mt19937 random(TestSeed());
  auto observations = Exact(Film(), Truth(), 20, TestSeed());
  AddNoise(&observations, &random);
  const auto clean = Resect(Film(), observations, Truth());
  observations[3].photo_mm += Eigen::Vector2d(4, -3);
  observations[11].photo_mm += Eigen::Vector2d(-2, 5);
  const auto plain = Resect(Film(), observations, Truth());
  ResectionOptions options;
  options.robust_scale = 2;
  const auto robust = Resect(Film(), observations, Disturbed(Truth(), 5, 0.002), options);
  ASSERT_TRUE(clean && plain && robust);
  EXPECT_GT(Error(plain->pose, clean->pose).head<3>().norm(), 2);
  EXPECT_LT(Error(robust->pose, clean->pose).head<3>().norm(), 0.3);
  // A blunder no longer counts: nearly all of it is redundant, and the covariance knows.
  EXPECT_GT(robust->redundancy[3], 1.99);
  EXPECT_GT(robust->covariance.trace(), clean->covariance.trace());
  EXPECT_NEAR(robust->residuals_mm[3].norm(), 5, 0.1);
}

// Beyond half, some fits stall before they converge: no reason to give the photo up.
TEST(Resect, ACauchyLossConvergesAmongSixtyPerCentBlunders) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> any(-1, 1);
  Camera camera;
  camera.principal_distance_mm = 153;
  camera.frame_mm = {230, 230};
  for (int trial = 0; trial < 200; ++trial) {
    const Pose truth{{500000, 5000000, 1500}, {0.02 * normal(random), 0.02 * normal(random), 1}};
    std::vector<ControlObservation> control;
    for (int i = 0; i < 75; ++i) {
      const Eigen::Vector3d ground(500000 + 900 * any(random), 5000000 + 900 * any(random),
                                   30 * normal(random));
      const double sigma_mm = 0.0025 * (0.5 + 1.5 * std::abs(any(random)));
      Eigen::Vector2d photo = PhotoFromGround(camera, truth, ground).value() +
                              sigma_mm * Eigen::Vector2d(normal(random), normal(random));
      if (any(random) < 0.2) photo += 0.25 * Eigen::Vector2d(any(random), any(random));
      control.push_back({ground, photo, sigma_mm * sigma_mm * Eigen::Matrix2d::Identity()});
    }
    Pose start = truth;
    start.position_m += 3 * Eigen::Vector3d(normal(random), normal(random), normal(random));
    Vector6d open;
    open << 300, 300, 300, 0.2, 0.2, 0.2;
    ResectionOptions robust;
    robust.robust_scale = 2;
    robust.prior = PosePrior{start, open.cwiseAbs2().asDiagonal()};
    EXPECT_TRUE(Resect(camera, control, start, robust)) << trial;
  }
}

TEST(Resect, TooFewPointsAndNoPriorAreSingular) {
  auto observations = Exact(Film(), Truth(), 2, TestSeed());
  EXPECT_FALSE(Resect(Film(), observations, Truth()));
  EXPECT_FALSE(Resect(Film(), {}, Truth()));
  observations.push_back(observations.back());  // the same point twice is one point
  EXPECT_FALSE(Resect(Film(), observations, Truth()));
  ResectionOptions options;
  options.prior = PosePrior{Truth(), Matrix6d::Identity()};
  EXPECT_TRUE(Resect(Film(), observations, Truth(), options));
}

TEST(Resect, CollinearGroundPointsAreSingular) {
  std::vector<ControlObservation> observations(5);
  for (std::size_t i = 0; i < 5; ++i) {
    const double s = static_cast<double>(i);
    observations[i].ground_m = Truth().position_m + Eigen::Vector3d(-600 + 300 * s, 200, -1700);
    observations[i].photo_mm = PhotoFromGround(Film(), Truth(), observations[i].ground_m).value();
  }
  EXPECT_FALSE(Resect(Film(), observations, Truth()));
  EXPECT_FALSE(Resect(Film(), observations, Disturbed(Truth(), 10, 0.01)));
}

TEST(Resect, OnTheDangerCylinderThreePointsAreSingular) {
  const Pose truth = {{500, 0, 1000}, {0, 0, 0}};
  std::vector<ControlObservation> observations(3);
  for (std::size_t i = 0; i < 3; ++i) {
    const double angle = 2.0 + 1.1 * static_cast<double>(i);
    observations[i].ground_m = {500 * std::cos(angle), 500 * std::sin(angle), 0};
    observations[i].photo_mm = PhotoFromGround(Film(), truth, observations[i].ground_m).value();
  }
  EXPECT_FALSE(Resect(Film(), observations, truth));
}

TEST(Resect, APointBehindTheCameraHasNoAnswer) {
  auto observations = Exact(Film(), Truth(), 5, TestSeed());
  observations[2].ground_m.z() = Truth().position_m.z() + 100;
  EXPECT_FALSE(Resect(Film(), observations, Truth()));
}

TEST(Resect, TooFewIterationsAreNoAnswer) {
  ResectionOptions options;
  options.max_iterations = 1;
  EXPECT_FALSE(Resect(Film(), Exact(Film(), Truth(), 8, TestSeed()),
                      Disturbed(Truth(), 150, RadFromDeg(5)), options));
}

TEST(Resect, BrokenPromises) {
  auto observations = Exact(Film(), Truth(), 5, TestSeed());
  ResectionOptions options;
  options.robust_scale = -1;
  EXPECT_THROW(Resect(Film(), observations, Truth(), options), std::invalid_argument);
  options = {};
  options.max_iterations = 0;
  EXPECT_TRUE(options.Check().has_value());
  options = {};
  options.prior = PosePrior{Truth(), Matrix6d::Zero()};
  EXPECT_THROW(Resect(Film(), observations, Truth(), options), std::invalid_argument);
  observations[1].covariance_mm2.setZero();
  EXPECT_THROW(Resect(Film(), observations, Truth()), std::invalid_argument);
}

}  // namespace
}  // namespace orient
