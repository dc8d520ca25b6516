// A pose with its principal distance: what relief tells, what level ground leaves open.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "exterior/steps/correlated_pose.h"
#include "tests/exterior/digital_view.h"

namespace orient::exterior {
namespace {

constexpr double kNoisePx = 0.1;
constexpr double kPrior_mm = 0.5;

struct Made {
  PhotoView view;  // the truth
  std::vector<PatchObservation> observations;
};

Made Make(double relief_m, std::mt19937& random) {
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit;
  Made made{DigitalView(), {}};
  while (made.observations.size() < 60) {
    const Eigen::Vector3d ground(made.view.pose.position_m.x() + 6000 * (unit(random) - 0.5),
                                 made.view.pose.position_m.y() + 6000 * (unit(random) - 0.5),
                                 500 + relief_m * unit(random));
    const auto pixel = made.view.PixelFromGround(ground);
    if (!pixel || pixel->minCoeff() < 0 || pixel->x() > 640 || pixel->y() > 1152) continue;
    PatchObservation o{ground, *pixel + kNoisePx * Eigen::Vector2d(normal(random), normal(random)),
                       kNoisePx * kNoisePx * Eigen::Matrix2d::Identity()};
    made.observations.push_back(o);
  }
  return made;
}

std::optional<CorrelatedPose> Estimate(const Made& made, const PosePrior& prior, double wrong_mm) {
  PhotoView start = made.view;
  start.pose = prior.pose;
  start.camera.principal_distance_mm += wrong_mm;
  return EstimateCorrelatedPose(
      start, prior, made.observations, {},
      PrincipalDistancePrior{start.camera.principal_distance_mm, kPrior_mm});
}

// Normalised errors of the six elements and of the principal distance.
TEST(PrincipalDistance, IsAsNearToTheTruthAsItsCovarianceSays) {
  for (const double relief_m : {0.0, 800.0}) {
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    double pose_square = 0, distance_square = 0;
    constexpr int kRuns = 60;
    for (int run = 0; run < kRuns; ++run) {
      const Made made = Make(relief_m, random);
      const PosePrior prior = PriorOf(made.view.pose, {20, 0.01}, random);
      const auto estimated = Estimate(made, prior, kPrior_mm * normal(random));
      ASSERT_TRUE(estimated);
      const Vector6d off = PoseDifference(estimated->pose, made.view.pose);
      pose_square += off.dot(estimated->covariance.ldlt().solve(off)) / 6;
      distance_square +=
          std::pow((estimated->principal_distance_mm - made.view.camera.principal_distance_mm) /
                       estimated->principal_distance_sigma_mm,
                   2);
    }
    EXPECT_NEAR(std::sqrt(pose_square / kRuns), 1, 0.2) << relief_m;
    EXPECT_NEAR(std::sqrt(distance_square / kRuns), 1, 0.25) << relief_m;
  }
}

TEST(PrincipalDistance, ReliefTellsItAndLevelGroundDoesNot) {
  std::mt19937 random(6);
  const Made level = Make(0, random), hills = Make(800, random);
  const PosePrior prior = PriorOf(level.view.pose, {20, 0.01}, random);
  const auto open = Estimate(level, prior, 0.4), told = Estimate(hills, prior, 0.4);
  ASSERT_TRUE(open && told);
  EXPECT_LT(told->principal_distance_sigma_mm, 0.25 * kPrior_mm);
  EXPECT_NEAR(told->principal_distance_mm, 120, 4 * told->principal_distance_sigma_mm);
  EXPECT_GT(open->principal_distance_sigma_mm, 3 * told->principal_distance_sigma_mm);
  // The flying height is uncertain by what the principal distance leaves open.
  EXPECT_GT(open->covariance(2, 2), 9 * told->covariance(2, 2));
}

// A source that may be displaced and deformed as a whole moves the estimate more than the prior's
// sigma: that is how far it can be off, and the flying height with it.
TEST(PrincipalDistance, IsNoLessCertainThanThePriorAndWhereItLiesFromIt) {
  std::mt19937 random(8);
  Made made = Make(300, random);
  for (PatchObservation& o : made.observations) o.source_sigma_px = 3;
  const PosePrior prior = PriorOf(made.view.pose, {20, 0.01}, random);
  const auto estimated = Estimate(made, prior, 0.1);
  ASSERT_TRUE(estimated);
  const double off_mm =
      estimated->principal_distance_mm - (made.view.camera.principal_distance_mm + 0.1);
  const double most_mm = std::hypot(off_mm, kPrior_mm);
  EXPECT_NEAR(estimated->principal_distance_sigma_mm, most_mm, 1e-9);
  const Matrix6d& covariance = estimated->honest_covariance;
  EXPECT_GT(covariance.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
}

TEST(PrincipalDistance, NeedsFourObservations) {
  std::mt19937 random(7);
  Made made = Make(300, random);
  made.observations.resize(3);
  EXPECT_FALSE(Estimate(made, PriorOf(made.view.pose, {20, 0.01}, random), 0));
}

}  // namespace
}  // namespace orient::exterior
