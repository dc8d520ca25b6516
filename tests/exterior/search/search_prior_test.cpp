#include "exterior/search/search_prior.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace orient::exterior {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kGround_m = 200, kHeight_m = 1500;
constexpr double kOff = 1e-6;  // relative

Camera AerialCamera() {
  Camera camera;
  camera.principal_distance_mm = 150;
  camera.frame_mm = {230, 180};  // a tenth of the shorter side: 18 mm, 180 m on the ground
  return camera;
}

PosePrior PriorOf(double position_m, double tilt_rad, double kappa_rad) {
  Vector6d sigma;
  sigma << position_m, position_m, position_m, tilt_rad, tilt_rad, kappa_rad;
  return {{{0, 0, kGround_m + kHeight_m}, {0, 0, 0}}, sigma.cwiseAbs2().asDiagonal()};
}

bool IsVague(const PosePrior& prior) { return exterior::IsVague(AerialCamera(), prior, kGround_m); }

TEST(IsVague, AnApproximationToMetresAndDegreesIsNot) {
  EXPECT_FALSE(IsVague(PriorOf(10, 3 * kDegree, 3 * kDegree)));
}

TEST(IsVague, WhereKappaIsOpenByMoreThanTwelveDegrees) {
  EXPECT_FALSE(IsVague(PriorOf(10, 0.01, 12 * kDegree * (1 - kOff))));
  EXPECT_TRUE(IsVague(PriorOf(10, 0.01, 12 * kDegree * (1 + kOff))));
}

TEST(IsVague, WhereThePositionMovesThePatchesByMoreThanATenthOfTheShorterSide) {
  EXPECT_FALSE(IsVague(PriorOf(180 * (1 - kOff), 0, 0)));
  EXPECT_TRUE(IsVague(PriorOf(180 * (1 + kOff), 0, 0)));
}

TEST(IsVague, WhereTheTiltMovesThePatchesByMoreThanATenthOfTheShorterSide) {
  EXPECT_FALSE(IsVague(PriorOf(0, 0.12 * (1 - kOff), 0)));
  EXPECT_TRUE(IsVague(PriorOf(0, 0.12 * (1 + kOff), 0)));
}

TEST(IsVague, WherePositionAndTiltDoTogether) {
  const double part = std::sqrt(0.5);
  EXPECT_FALSE(IsVague(PriorOf(part * 180 * (1 - kOff), part * 0.12 * (1 - kOff), 0)));
  EXPECT_TRUE(IsVague(PriorOf(part * 180 * (1 + kOff), part * 0.12 * (1 + kOff), 0)));
}

TEST(IsVague, TheWorstOfXAndYAndOfOmegaAndPhiCounts) {
  for (const int i : {0, 1, 3, 4}) {
    PosePrior prior = PriorOf(10, 0.01, 0.01);
    prior.covariance(i, i) = std::pow(i < 3 ? 181 : 0.121, 2);
    EXPECT_TRUE(IsVague(prior)) << i;
  }
}

// Another height changes the scale and hardly where the patches lie.
TEST(IsVague, AnUnknownHeightIsNot) {
  PosePrior prior = PriorOf(10, 0.01, 0.01);
  prior.covariance(2, 2) = 1e6;
  EXPECT_FALSE(IsVague(prior));
}

TEST(IsVague, AnApproximationBelowTheGroundIsWrongAndNotVague) {
  PosePrior prior = PriorOf(1e4, 1, 3);
  prior.pose.position_m.z() = kGround_m;
  EXPECT_FALSE(IsVague(prior));
  prior.pose.position_m.z() = kGround_m - 1;
  EXPECT_FALSE(IsVague(prior));
  prior.pose.position_m.z() = kGround_m + 1;
  EXPECT_TRUE(IsVague(prior));
}

Vector6d SigmaOfWidened(const PosePrior& prior) {
  return Widened(prior, kGround_m).covariance.diagonal().cwiseSqrt();
}

TEST(Widened, AllowsAnyKappaAThirdOfTheFlyingHeightAndATenthOfScale) {
  const Vector6d sigma = SigmaOfWidened(PriorOf(0, 0, 0));
  EXPECT_NEAR(sigma[0], 450, 1e-9);
  EXPECT_NEAR(sigma[1], 450, 1e-9);
  EXPECT_NEAR(sigma[2], 150, 1e-9);
  EXPECT_NEAR(sigma[5], std::numbers::pi, 1e-12);
}

TEST(Widened, AddsToWhatThePriorAllows) {
  const Vector6d sigma = SigmaOfWidened(PriorOf(600, 0, 1));
  EXPECT_NEAR(sigma[0], std::hypot(450, 600), 1e-9);
  EXPECT_NEAR(sigma[2], std::hypot(150, 600), 1e-9);
  EXPECT_NEAR(sigma[5], std::numbers::pi, 1e-12) << "there is no more of kappa";
}

TEST(Widened, AllowsTheTiltOfAerialPhotosFiveToTwelveDegrees) {
  for (const auto& [stated, allowed] : {std::pair(0.0, 5.0), {5.0, 5.0}, {8.0, 8.0}, {60.0, 12.0}})
    for (const int i : {3, 4})
      EXPECT_NEAR(SigmaOfWidened(PriorOf(10, stated * kDegree, 0))[i], allowed * kDegree, 1e-12);
}

TEST(Widened, ForgetsCorrelationsAndKeepsThePose) {
  PosePrior prior = PriorOf(10, 0.01, 0.01);
  prior.pose.opk_rad = {0.1, -0.2, 0.3};
  prior.covariance(0, 4) = prior.covariance(4, 0) = 0.05;
  const PosePrior wide = Widened(prior, kGround_m);
  EXPECT_EQ(wide.pose.AsVector(), prior.pose.AsVector());
  EXPECT_EQ(wide.covariance, Matrix6d(wide.covariance.diagonal().asDiagonal()));
}

TEST(Widened, BelowTheGroundStillAllowsSomething) {
  PosePrior prior = PriorOf(0, 0, 0);
  prior.pose.position_m.z() = kGround_m - 500;
  EXPECT_NEAR(SigmaOfWidened(prior)[0], 0.3, 1e-9) << "as a metre above it";
}

TEST(IsPositionKnown, ToAFewPerCentOfTheFlyingHeight) {
  PosePrior prior{{{0, 0, 2500}, {0, 0, 0}}, Matrix6d::Identity()};
  const auto with = [&](double sigma_m) {
    prior.covariance.topLeftCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    return IsPositionKnown(prior, 100);
  };
  EXPECT_TRUE(with(100));
  EXPECT_FALSE(with(300));
  EXPECT_FALSE(IsPositionKnown(prior, 3000));
}

TEST(HeightFactors, GoOutwardsAsFarAsTheHeightIsUncertainButOneStepAtLeast) {
  PosePrior prior = PriorOf(10, 0.01, 0.01);
  prior.covariance(2, 2) = 0;
  const std::vector<double> known = HeightFactors(prior, kGround_m);
  ASSERT_EQ(known.size(), 3u);
  EXPECT_EQ(known[0], 1);
  EXPECT_DOUBLE_EQ(known[1], 1.2);
  EXPECT_DOUBLE_EQ(known[2], 1 / 1.2);
  prior.covariance(2, 2) = 1e12;  // twice the height and half of it: four steps of a fifth
  const std::vector<double> factors = HeightFactors(prior, kGround_m);
  ASSERT_EQ(factors.size(), 9u);
  EXPECT_NEAR(factors[7], 2.0736, 1e-12);
  EXPECT_NEAR(factors[8] * factors[7], 1, 1e-12);
}

TEST(KappaSectors, AreAllWhereKappaIsOpenAndTheOwnOneComesFirst) {
  const auto sectors = KappaSectors(PriorOf(10, 0.01, 180 * kDegree), false);
  ASSERT_EQ(std::ssize(sectors), kKappaSectors);
  EXPECT_EQ(sectors[0].pose.opk_rad.z(), 0);
  std::vector<double> kappas;
  for (const PosePrior& sector : sectors) {
    kappas.push_back(sector.pose.opk_rad.z());
    EXPECT_NEAR(std::sqrt(sector.covariance(5, 5)), 22.5 * kDegree / std::sqrt(12), 1e-12);
  }
  std::sort(kappas.begin(), kappas.end());
  for (std::size_t i = 1; i < kappas.size(); ++i)
    EXPECT_NEAR(kappas[i] - kappas[i - 1], 22.5 * kDegree, 1e-12);
}

TEST(KappaSectors, OfAllTheOppositeOneComesSecondAndThenThoseAtRightAngles) {
  const auto sectors = KappaSectors(PriorOf(10, 0.01, 1 * kDegree), true);
  EXPECT_EQ(sectors[0].pose.opk_rad.z(), 0);
  EXPECT_NEAR(sectors[1].pose.opk_rad.z(), 180 * kDegree, 1e-12);
  EXPECT_NEAR(sectors[2].pose.opk_rad.z(), 90 * kDegree, 1e-12);
  EXPECT_NEAR(sectors[3].pose.opk_rad.z(), -90 * kDegree, 1e-12);
  EXPECT_NEAR(sectors[4].pose.opk_rad.z(), 22.5 * kDegree, 1e-12);
}

TEST(KappaSectors, AreThoseWithinThreeSigmaUnlessAllAreWanted) {
  const PosePrior prior = PriorOf(10, 0.01, 14 * kDegree);  // 42 degrees reach into the second
  EXPECT_EQ(KappaSectors(prior, false).size(), 5u);
  EXPECT_EQ(std::ssize(KappaSectors(prior, true)), kKappaSectors);
  EXPECT_EQ(KappaSectors(PriorOf(10, 0.01, 1 * kDegree), false).size(), 1u);
}

TEST(KappaSectors, AreNoLessPreciseThanKappaIsUnlessThatHasFailed) {
  const PosePrior prior = PriorOf(10, 0.2, 1 * kDegree);
  EXPECT_EQ(KappaSectors(prior, false)[0].covariance(5, 5), prior.covariance(5, 5));
  EXPECT_GT(KappaSectors(prior, true)[0].covariance(5, 5), prior.covariance(5, 5));
}

}  // namespace
}  // namespace orient::exterior
