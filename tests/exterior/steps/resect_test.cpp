#include "exterior/steps/resect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr PriorSigma kPriorSigma{50, 0.02};
constexpr double kNoisePx = 0.2;

std::vector<PatchObservation> Observe(const PhotoView& view, int count, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal(0, kNoisePx);
  std::vector<PatchObservation> observations;
  while (static_cast<int>(observations.size()) < count) {
    PatchObservation o;
    o.ground_m = {1000 + 2500 * unit(random), 2000 + 2500 * unit(random), 400 + 200 * unit(random)};
    const auto pixel = view.PixelFromGround(o.ground_m);
    if (!pixel || !view.camera.InFrame(view.photo_from_pixel * *pixel)) continue;
    o.pixel = *pixel + Eigen::Vector2d(normal(random), normal(random));
    // The weights are wrong on purpose by a common factor: the residuals must correct it.
    o.covariance_px2 = Eigen::Matrix2d::Identity() * (0.1 * 0.1);
    observations.push_back(o);
  }
  return observations;
}

TEST(EstimatePose, NormalisedErrorsAreStandardNormal) {
  std::mt19937 random(TestSeed());
  Vector6d squares = Vector6d::Zero();
  constexpr int kRuns = 150;
  for (int run = 0; run < kRuns; ++run) {
    PhotoView view = DigitalView();
    const Pose truth = view.pose;
    const auto observations = Observe(view, 40, random);
    const PosePrior prior = PriorOf(truth, kPriorSigma, random);
    view.pose = prior.pose;
    const auto estimate = EstimatePose(view, prior, observations);
    ASSERT_TRUE(estimate);
    squares += (estimate->pose.AsVector() - truth.AsVector())
                   .cwiseAbs2()
                   .cwiseQuotient(estimate->covariance.diagonal());
  }
  const Vector6d rms = (squares / kRuns).cwiseSqrt();
  EXPECT_GT(rms.minCoeff(), 0.8);
  EXPECT_LT(rms.maxCoeff(), 1.25);
}

TEST(EstimatePose, Sigma0IsTheNoiseOfTheImagePoints) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  const auto observations = Observe(view, 400, random);
  const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), observations);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->sigma0_px, kNoisePx, 0.1 * kNoisePx);
}

TEST(EstimatePose, NamesGrossErrorsAndKeepsTheRest) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  auto observations = Observe(view, 60, random);
  for (std::size_t i = 0; i < 18; ++i)
    observations[i].pixel += Eigen::Vector2d(3, -2) * (1.0 + static_cast<double>(i % 5));
  const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), observations);
  ASSERT_TRUE(estimate);
  int wrongly_rejected = 0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    if (i < 18)
      EXPECT_TRUE(estimate->rejected[i]) << i;
    else
      wrongly_rejected += estimate->rejected[i] ? 1 : 0;
  }
  EXPECT_LE(wrongly_rejected, 3);
}

// Matching is sure of its best textures, but the ground is not as sure: errors of 0.3 px with
// sigmas between 0.02 and 0.3. Without a variance that is common to all, gross errors of some
// pixels pass among those of poor texture.
TEST(EstimatePose, WhatMatchingCannotSeeIsFoundFromTheResiduals) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> normal(0, 0.3);
  PhotoView view = DigitalView();
  auto observations = Observe(view, 80, random);
  for (std::size_t i = 0; i < observations.size(); ++i) {
    observations[i].pixel = *view.PixelFromGround(observations[i].ground_m) +
                            Eigen::Vector2d(normal(random), normal(random));
    observations[i].covariance_px2 =
        Eigen::Matrix2d::Identity() *
        std::pow(0.02 * std::pow(15, static_cast<double>(i % 10) / 9), 2);
    if (i < 20) observations[i].pixel += Eigen::Vector2d(3, -1.5);
  }
  const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), observations);
  ASSERT_TRUE(estimate);
  for (std::size_t i = 0; i < 20; ++i) EXPECT_TRUE(estimate->rejected[i]) << i;
  EXPECT_GE(estimate->used, 55);
  EXPECT_NEAR(estimate->sigma0_px, 0.3, 0.1);
}

// As the others fit by chance or because they are better than stated: that does not make a match
// wrong which is off by no more than its own precision allows.
TEST(EstimatePose, WhatFitsItsOwnPrecisionIsNoGrossErrorHoweverWellTheOthersFit) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  auto observations = Observe(view, 40, random);
  for (PatchObservation& o : observations)  // the noise is a tenth of what is stated
    o.covariance_px2 = Eigen::Matrix2d::Identity() * std::pow(10 * kNoisePx, 2);
  observations[0].pixel += Eigen::Vector2d(2, 0) * 10 * kNoisePx;  // two sigma
  observations[1].pixel += Eigen::Vector2d(8, 0) * 10 * kNoisePx;
  const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), observations);
  ASSERT_TRUE(estimate);
  EXPECT_FALSE(estimate->rejected[0]);
  EXPECT_TRUE(estimate->rejected[1]);
}

// What chance could produce is judged by it: the area of sigma0 would be a hundredth of it here.
TEST(EstimatePose, PassingAreaIsThatInWhichObservationsPassHoweverWellTheOthersFit) {
  std::mt19937 random(TestSeed());
  PhotoView view = DigitalView();
  auto observations = Observe(view, 60, random);
  for (PatchObservation& o : observations)  // the noise is a tenth of what is stated
    o.covariance_px2 = Eigen::Matrix2d::Identity() * std::pow(10 * kNoisePx, 2);
  const auto passes = [&](double off_px) {
    auto moved = observations;
    moved[0].pixel = *view.PixelFromGround(moved[0].ground_m) + Eigen::Vector2d(off_px, 0);
    const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), moved);
    return estimate && !estimate->rejected[0];
  };
  const auto estimate = EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), observations);
  ASSERT_TRUE(estimate);
  const double radius = std::sqrt(estimate->passing_px2[0] / std::numbers::pi);
  EXPECT_TRUE(passes(0.9 * radius));
  EXPECT_FALSE(passes(1.3 * radius));
}

TEST(EstimatePose, ThreeObservationsAreTooFew) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  EXPECT_FALSE(
      EstimatePose(view, PriorOf(view.pose, kPriorSigma, random), Observe(view, 3, random)));
}

TEST(EstimatePose, AWrongPriorShowsInItsChiSquare) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  PosePrior prior = PriorOf(view.pose, kPriorSigma, random);
  prior.pose.position_m.x() += 2000;
  const auto estimate = EstimatePose(view, prior, Observe(view, 60, random));
  ASSERT_TRUE(estimate);
  EXPECT_GT(estimate->prior_chi2, 100);
}

TEST(WorstProjectionSigma, GrowsTowardsTheFrameWherePointsLieOnOneSide) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  auto all = Observe(view, 80, random);
  std::vector<PatchObservation> one_side;
  for (const PatchObservation& o : all)
    if (o.pixel.y() < 400) one_side.push_back(o);
  const PosePrior prior = PriorOf(view.pose, kPriorSigma, random);
  const auto good = EstimatePose(view, prior, all);
  const auto poor = EstimatePose(view, prior, one_side);
  ASSERT_TRUE(good && poor);
  EXPECT_GT(WorstProjectionSigma(view, poor->covariance, 400),
            3 * WorstProjectionSigma(view, good->covariance, 400));
}

// A pose that shows no ground, or whose covariance is none, must never pass for a good one.
TEST(WorstProjectionSigma, IsInfiniteWhereNothingIsKnown) {
  PhotoView view = DigitalView();
  const Matrix6d covariance = Matrix6d::Identity() * 1e-6;
  EXPECT_TRUE(std::isfinite(WorstProjectionSigma(view, covariance, 400)));
  EXPECT_TRUE(std::isinf(WorstProjectionSigma(view, covariance * std::nan(""), 400)));
  view.pose.opk_rad.x() = RadFromDeg(170);
  EXPECT_TRUE(std::isinf(WorstProjectionSigma(view, covariance, 400)));
}

}  // namespace
}  // namespace orient::exterior
