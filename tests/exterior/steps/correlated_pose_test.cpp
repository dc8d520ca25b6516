#include "exterior/steps/correlated_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr PriorSigma kPriorSigma{100, 0.03};
constexpr double kNoisePx = 0.15;
constexpr double kHeightSigma = 3;      // m
constexpr double kSourceHeight = 4500;  // m above ground, nadir at (1500, 3500)

// Patches cut from one photo with heights that are wrong by one value everywhere.
std::vector<PatchObservation> Observe(const PhotoView& view, double height_error, int count,
                                      std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal(0, kNoisePx);
  std::vector<PatchObservation> observations;
  while (static_cast<int>(observations.size()) < count) {
    PatchObservation o;
    const Eigen::Vector3d truth(1000 + 2500 * unit(random), 2000 + 2500 * unit(random),
                                400 + 200 * unit(random));
    const auto pixel = view.PixelFromGround(truth);
    if (!pixel || !view.camera.InFrame(view.photo_from_pixel * *pixel)) continue;
    o.height_effect = {(1500 - truth.x()) / kSourceHeight, (3500 - truth.y()) / kSourceHeight, 1};
    o.ground_m = truth + height_error * o.height_effect;
    o.pixel = *pixel + Eigen::Vector2d(normal(random), normal(random));
    o.covariance_px2 = Eigen::Matrix2d::Identity() * (0.1 * 0.1);
    o.height_sigma_m = kHeightSigma;
    observations.push_back(o);
  }
  return observations;
}

struct Scatter {
  Vector6d rms = Vector6d::Zero();  // normalised
};

Scatter Simulate(bool tell_of_heights, int runs, std::mt19937& random) {
  std::normal_distribution<double> normal;
  Scatter scatter;
  for (int run = 0; run < runs; ++run) {
    PhotoView view = DigitalView();
    const Pose truth = view.pose;
    auto observations = Observe(view, kHeightSigma * normal(random), 60, random);
    if (!tell_of_heights)
      for (PatchObservation& o : observations) o.height_sigma_m = 0;
    const PosePrior prior = PriorOf(truth, kPriorSigma, random);
    view.pose = prior.pose;
    const auto estimate = EstimateCorrelatedPose(view, prior, observations, {});
    EXPECT_TRUE(estimate);
    if (!estimate) break;
    scatter.rms += (estimate->pose.AsVector() - truth.AsVector())
                       .cwiseAbs2()
                       .cwiseQuotient(estimate->covariance.diagonal());
  }
  scatter.rms = (scatter.rms / runs).cwiseSqrt();
  return scatter;
}

TEST(CorrelatedPose, PrecisionHoldsWhereHeightsAreWrongEverywhere) {
  std::mt19937 random(TestSeed());
  const Scatter scatter = Simulate(true, 120, random);
  EXPECT_GT(scatter.rms.minCoeff(), 0.6);
  EXPECT_LT(scatter.rms.maxCoeff(), 1.25);
}

TEST(CorrelatedPose, WithoutKnowingOfHeightsThePrecisionIsALie) {
  std::mt19937 random(TestSeed());
  EXPECT_GT(Simulate(false, 60, random).rms.maxCoeff(), 1.25);
}

// Of sixteen numbers six go into the pose: what is left is less than the noise, and says so itself
// with little certainty.
TEST(CorrelatedPose, PrecisionHoldsForEightPatches) {
  std::mt19937 random(TestSeed());
  constexpr int kRuns = 300;
  double squares = 0;
  for (int run = 0; run < kRuns; ++run) {
    PhotoView view = DigitalView();
    const Pose truth = view.pose;
    auto observations = Observe(view, 0, 8, random);
    for (PatchObservation& o : observations) o.height_sigma_m = 0;
    const PosePrior prior = PriorOf(truth, {1000, 0.3}, random);
    const auto estimate = EstimateCorrelatedPose(view, prior, observations, {});
    ASSERT_TRUE(estimate);
    const Vector6d error = PoseDifference(estimate->pose, truth);
    squares += error.dot(estimate->covariance.ldlt().solve(error)) / 6;
  }
  EXPECT_NEAR(std::sqrt(squares / kRuns), 1, 0.08);
}

// Along an edge the point lies where it was predicted, and the covariance says that it is open.
TEST(CorrelatedPose, PrecisionHoldsWhereHalfOfThePatchesAreEdges) {
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<double> any(-3, 3);
  constexpr int kRuns = 100;
  constexpr double kOpen_px = 5;
  double squares = 0, information = 0;
  for (int run = 0; run < kRuns; ++run) {
    PhotoView view = DigitalView();
    const Pose truth = view.pose;
    auto observations = Observe(view, 0, 80, random);
    for (PatchObservation& o : observations) o.height_sigma_m = 0;
    std::vector<PatchObservation> corners(observations.begin() + 40, observations.end());
    const PosePrior prior = PriorOf(truth, {10, 0.003}, random);
    const PhotoView predicting{view.camera, view.photo_from_pixel, prior.pose, {}};
    for (std::size_t i = 0; i < 40; ++i) {
      PatchObservation& o = observations[i];
      const double angle = any(random);
      const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
      o.covariance_px2 += kOpen_px * kOpen_px * along * along.transpose();
      const Eigen::Vector2d off = *predicting.PixelFromGround(o.ground_m) - o.pixel;
      if (off.norm() < kOpen_px) o.pixel += along * along.dot(off);
    }
    const auto estimate = EstimateCorrelatedPose(view, prior, observations, {});
    const auto less = EstimateCorrelatedPose(view, prior, corners, {});
    ASSERT_TRUE(estimate && less);
    const Vector6d error = PoseDifference(estimate->pose, truth);
    squares += error.dot(estimate->covariance.ldlt().solve(error)) / 6;
    information += std::log(less->covariance.determinant() / estimate->covariance.determinant());
  }
  EXPECT_GT(std::sqrt(squares / kRuns), 0.8);
  EXPECT_LT(std::sqrt(squares / kRuns), 1.2);
  EXPECT_GT(information / kRuns, 1) << "edges tell nothing";
}

TEST(CorrelatedPose, NoiseFactorIsWhatTheResidualsSay) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  auto observations = Observe(view, 0, 300, random);
  for (PatchObservation& o : observations) o.height_sigma_m = 0;
  const auto estimate =
      EstimateCorrelatedPose(view, PriorOf(view.pose, kPriorSigma, random), observations, {});
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(std::sqrt(estimate->noise_factor) * 0.1, kNoisePx, 0.1 * kNoisePx);
}

// Along an edge nothing was measured that could fit well.
TEST(CorrelatedPose, NoiseFactorDoesNotFallWithTheShareOfEdges) {
  constexpr double kOpen_px = 5;
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<double> any(-3, 3);
  PhotoView view = DigitalView();
  auto observations = Observe(view, 0, 240, random);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    PatchObservation& o = observations[i];
    o.height_sigma_m = 0;
    if (i % 3 == 0) continue;
    const double angle = any(random);
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    o.covariance_px2 += kOpen_px * kOpen_px * along * along.transpose();
    o.pixel += along * along.dot(*view.PixelFromGround(o.ground_m) - o.pixel);
  }
  const auto estimate =
      EstimateCorrelatedPose(view, PriorOf(view.pose, kPriorSigma, random), observations, {});
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(std::sqrt(estimate->noise_factor) * 0.1, kNoisePx, 0.1 * kNoisePx);
}

TEST(CorrelatedPose, AnUncertainInteriorOrientationMakesThePoseUncertain) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  const PosePrior prior = PriorOf(view.pose, kPriorSigma, random);
  const auto observations = Observe(view, 0, 60, random);
  CommonErrors common;
  common.interior.diagonal() << 1e-12, 1e-12, 1e-12, 1e-12, 1e-2, 1e-2;  // 0.1 mm of shift
  const auto certain = EstimateCorrelatedPose(view, prior, observations, {});
  const auto uncertain = EstimateCorrelatedPose(view, prior, observations, common);
  ASSERT_TRUE(certain && uncertain);
  // All frames look the same from 4 m beside with the film 0.1 mm off.
  for (int i = 0; i < 2; ++i) EXPECT_GT(uncertain->covariance(i, i), 2 * certain->covariance(i, i));
}

TEST(CorrelatedPose, BendingFilmMakesThePoseUncertain) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  const PosePrior prior = PriorOf(view.pose, kPriorSigma, random);
  const auto observations = Observe(view, 0, 60, random);
  CommonErrors common;
  common.film_sigma_px = 0.2;
  common.film_correlation_px = 300;
  const auto certain = EstimateCorrelatedPose(view, prior, observations, {});
  const auto uncertain = EstimateCorrelatedPose(view, prior, observations, common);
  ASSERT_TRUE(certain && uncertain);
  for (int i = 0; i < 6; ++i) EXPECT_GT(uncertain->covariance(i, i), certain->covariance(i, i));
}

// Root of the mean of chi-square over its six degrees of freedom; honest: 1.
struct ChiOfPose {
  double of_adjustment = 0, honest = 0;
};

// Errors of one pixel in col and row that fade over the ground, as shadows and crowns make them.
std::vector<Eigen::Vector2d> SmoothErrors(const std::vector<PatchObservation>& observations,
                                          double length_m, std::mt19937& random) {
  const Eigen::Index n = std::ssize(observations);
  Eigen::MatrixXd correlation = 1e-9 * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const auto& one = observations[static_cast<std::size_t>(i)];
      const auto& other = observations[static_cast<std::size_t>(j)];
      const double distance = (one.ground_m - other.ground_m).head<2>().norm() / length_m;
      correlation(i, j) += std::exp(-distance * distance);
    }
  std::normal_distribution<double> normal;
  Eigen::MatrixX2d white(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) white.row(i) << normal(random), normal(random);
  const Eigen::MatrixX2d smooth = correlation.llt().matrixL() * white;
  std::vector<Eigen::Vector2d> errors;
  for (Eigen::Index i = 0; i < n; ++i) errors.emplace_back(smooth.row(i));
  return errors;
}

// All patches are seen off by the same shift and by smooth errors, others each time.
ChiOfPose ChiWithSharedErrors(double shift_px, double smooth_px, std::mt19937& random) {
  constexpr int kRuns = 100;
  std::normal_distribution<double> normal;
  ChiOfPose sum;
  for (int run = 0; run < kRuns; ++run) {
    PhotoView view = DigitalView();
    const Pose truth = view.pose;
    auto observations = Observe(view, 0, 60, random);
    const Eigen::Vector2d shift(shift_px * normal(random), shift_px * normal(random));
    const double flying_m = truth.position_m.z() - 400;
    const auto smooth = SmoothErrors(observations, 0.3 * flying_m, random);
    for (std::size_t i = 0; i < observations.size(); ++i)
      observations[i].pixel += shift + smooth_px * smooth[i];
    const PosePrior prior = PriorOf(truth, kPriorSigma, random);
    view.pose = prior.pose;
    const auto estimate = EstimateCorrelatedPose(view, prior, observations, {});
    EXPECT_TRUE(estimate);
    if (!estimate) break;
    const Vector6d error = PoseDifference(estimate->pose, truth);
    sum.of_adjustment += error.dot(estimate->covariance.ldlt().solve(error)) / (6 * kRuns);
    sum.honest += error.dot(estimate->honest_covariance.ldlt().solve(error)) / (6 * kRuns);
  }
  return {std::sqrt(sum.of_adjustment), std::sqrt(sum.honest)};
}

// Which residuals hardly show.
TEST(CorrelatedPose, HonestCovarianceCoversWhatAllPatchesShare) {
  std::mt19937 random(TestSeed());
  const ChiOfPose chi = ChiWithSharedErrors(0.5 * kNoisePx, 0.8 * kNoisePx, random);
  EXPECT_GT(chi.of_adjustment, 1.5);
  EXPECT_LT(chi.honest, 1.25);
  EXPECT_GT(chi.honest, 0.7);
}

TEST(CorrelatedPose, HonestCovarianceIsNowhereBelowTheAdjustments) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  const PosePrior prior = PriorOf(view.pose, kPriorSigma, random);
  for (const int count : {4, 20, 60}) {
    const auto estimate = EstimateCorrelatedPose(view, prior, Observe(view, 1, count, random), {});
    ASSERT_TRUE(estimate);
    const Vector6d sigma = estimate->covariance.diagonal().cwiseSqrt();
    const Matrix6d more = sigma.cwiseInverse().asDiagonal() *
                          (estimate->honest_covariance - estimate->covariance) *
                          sigma.cwiseInverse().asDiagonal();
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6d>(more).eigenvalues().minCoeff(), -1e-6)
        << count;
    EXPECT_GT(more.trace(), 0) << count;
  }
}

// The same prior, written as an angle of either side of 180 degrees, is the same prior.
TEST(CorrelatedPose, APriorAFullTurnAwayIsTheSamePrior) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  view.pose.opk_rad.z() = RadFromDeg(179.9);
  const auto observations = Observe(view, 0, 6, random);
  PosePrior prior{view.pose, Vector6d::Constant(1e-4).asDiagonal()};
  const auto same = EstimateCorrelatedPose(view, prior, observations, {});
  prior.pose.opk_rad.z() -= RadFromDeg(360);
  const auto turned = EstimateCorrelatedPose(view, prior, observations, {});
  ASSERT_TRUE(same && turned);
  EXPECT_LT((same->pose.AsVector() - turned->pose.AsVector()).norm(), 1e-6);
}

TEST(CorrelatedPose, ObservationsWithoutNoiseAreNotSingular) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  auto observations = Observe(view, 0, 12, random);
  for (PatchObservation& o : observations) {
    o.pixel = *view.PixelFromGround(o.ground_m);
    o.height_sigma_m = 0;
  }
  const PosePrior prior{view.pose, Vector6d::Constant(1e4).asDiagonal()};
  const auto estimate = EstimateCorrelatedPose(view, prior, observations, {});
  ASSERT_TRUE(estimate);
  EXPECT_GT(estimate->covariance.diagonal().minCoeff(), 0);
}

TEST(CorrelatedPose, ThreeObservationsAreTooFew) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  EXPECT_FALSE(EstimateCorrelatedPose(view, PriorOf(view.pose, kPriorSigma, random),
                                      Observe(view, 0, 3, random), {}));
}

}  // namespace
}  // namespace orient::exterior
