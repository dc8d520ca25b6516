// Height errors of synthetic photos whose truth is known: of a coarse DEM, of a survey, without
// correlation, of orthophotos, and sources that are displaced as a whole.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <random>

#include "core/geometry/collinearity.h"
#include "exterior/steps/correlated_pose.h"
#include "exterior/steps/error_model.h"
#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr PriorSigma kPriorSigma{100, 0.03};
constexpr double kNoisePx = 0.1;
constexpr double kHeightSigma_m = 3, kSourceHeight_m = 4500;
constexpr double kLength_m = 1450;  // of the long correlation; the short one is a fifth

enum class Field { kShort, kLong, kWhite };

// At the observations, of a standard deviation of 1.
Eigen::VectorXd Draw(Field field, const std::vector<PatchObservation>& observations,
                     std::mt19937& random) {
  std::normal_distribution<double> normal;
  const auto n = std::ssize(observations);
  Eigen::VectorXd white(n);
  for (double& value : white) value = normal(random);
  if (field == Field::kWhite) return white;
  Eigen::MatrixXd correlation = 1e-6 * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double distance_m = (observations[static_cast<std::size_t>(i)].ground_m -
                                 observations[static_cast<std::size_t>(j)].ground_m)
                                    .head<2>()
                                    .norm();
      correlation(i, j) += field == Field::kShort
                               ? std::exp(-std::pow(5 * distance_m / kLength_m, 2))
                               : std::exp(-distance_m / kLength_m);
    }
  return correlation.llt().matrixL() * white;
}

// Patches all over two fifths of the frame, as another strip shows it, of two sources. Nothing is
// wrong with them but noise.
std::vector<PatchObservation> Observe(const PhotoView& view, int count, bool orthophoto,
                                      std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  std::normal_distribution<double> normal(0, kNoisePx);
  std::vector<PatchObservation> observations;
  for (int i = 0; i < count; ++i) {
    PatchObservation o;
    const double height_m = 400 + 200 * unit(random);
    const Ray ray = *GroundRayFromPhoto(
        view.camera, view.pose,
        view.PhotoFromPixel({20 + 600 * unit(random), 20 + 440 * unit(random)}));
    o.ground_m = ray.origin_m + ray.direction * ((height_m - ray.origin_m.z()) / ray.direction.z());
    o.pixel = *view.PixelFromGround(o.ground_m) + Eigen::Vector2d(normal(random), normal(random));
    o.covariance_px2 = kNoisePx * kNoisePx * Eigen::Matrix2d::Identity();
    o.height_effect << (Eigen::Vector2d(1500, 3500) - o.ground_m.head<2>()) / kSourceHeight_m, 1;
    if (orthophoto) o.height_effect.z() = 0;
    o.height_sigma_m = kHeightSigma_m;
    if (orthophoto) o.surface_sigma_m = kHeightSigma_m;
    o.source = i % 2;
    observations.push_back(o);
  }
  return observations;
}

struct Tally {
  double squares = 0, honest_squares = 0;
  int runs = 0;

  void Add(const PhotoView& truth, const CorrelatedPose& estimate) {
    const Vector6d error = PoseDifference(estimate.pose, truth.pose);
    squares += error.dot(estimate.covariance.ldlt().solve(error)) / 6;
    honest_squares += error.dot(estimate.honest_covariance.ldlt().solve(error)) / 6;
    ++runs;
  }
  double Chi() const { return std::sqrt(squares / runs); }
  double HonestChi() const { return std::sqrt(honest_squares / runs); }
};

CommonErrors Common() {
  CommonErrors common;
  common.height_correlation_m = kLength_m;
  common.half_frame_px = 576;
  return common;
}

Tally WithHeightErrors(Field field, bool orthophoto) {
  std::mt19937 random(TestSeed());
  Tally tally;
  for (int run = 0; run < 20; ++run) {
    const PhotoView truth = DigitalView();
    auto observations = Observe(truth, 110, orthophoto, random);
    const Eigen::VectorXd of_source = Draw(field, observations, random);
    const Eigen::VectorXd of_surface = Draw(Field::kShort, observations, random);
    for (std::size_t i = 0; i < observations.size(); ++i) {
      PatchObservation& o = observations[i];
      const auto k = static_cast<Eigen::Index>(i);
      o.ground_m += kHeightSigma_m * of_source[k] * o.height_effect;
      o.ground_m.z() += o.surface_sigma_m * of_surface[k];
    }
    PhotoView view = truth;
    const PosePrior prior = PriorOf(truth.pose, kPriorSigma, random);
    view.pose = prior.pose;
    const auto estimate = EstimateCorrelatedPose(view, prior, observations, Common());
    EXPECT_TRUE(estimate);
    if (estimate) tally.Add(truth, *estimate);
  }
  return tally;
}

// Whatever the field is, the precision is that of the errors.
TEST(CorrelatedPoseHeights, OfACoarseDemMakeNoLieOfThePrecision) {
  const Tally tally = WithHeightErrors(Field::kShort, false);
  EXPECT_GT(tally.Chi(), 0.75);
  EXPECT_LT(tally.Chi(), 1.25);
}

TEST(CorrelatedPoseHeights, OfASurveyMakeNoLieOfThePrecision) {
  const Tally tally = WithHeightErrors(Field::kLong, false);
  EXPECT_GT(tally.Chi(), 0.7);
  EXPECT_LT(tally.Chi(), 1.25);
}

// The common share that is assumed makes it careful.
TEST(CorrelatedPoseHeights, WithoutCorrelationMakeNoLieOfThePrecision) {
  const Tally tally = WithHeightErrors(Field::kWhite, false);
  EXPECT_GT(tally.Chi(), 0.5);
  EXPECT_LT(tally.Chi(), 1.25);
}

TEST(CorrelatedPoseHeights, OfOrthophotosAreTheirOwnAndTheSurfaces) {
  const Tally tally = WithHeightErrors(Field::kLong, true);
  EXPECT_GT(tally.Chi(), 0.7);
  EXPECT_LT(tally.Chi(), 1.25);
}

// The pose follows an error that all have in common: that it leaves no residuals says nothing of
// it.
TEST(CorrelatedPoseHeights, WhatTheSurfacesOfOrthophotosHaveInCommonIsInTheHonestCovariance) {
  constexpr int kRuns = 60;
  constexpr double kSurface_m = 10;
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> normal(0, kSurface_m * std::sqrt(kCommonHeightShare));
  double squares = 0;
  for (int run = 0; run < kRuns; ++run) {
    const PhotoView truth = DigitalView();
    auto observations = Observe(truth, 60, true, random);
    const double too_high_m = normal(random);
    for (PatchObservation& o : observations) {
      o.surface_sigma_m = kSurface_m;
      o.ground_m.z() += too_high_m;
    }
    const PosePrior prior = PriorOf(truth.pose, kPriorSigma, random);
    const auto estimate = EstimateCorrelatedPose(truth, prior, observations, Common());
    ASSERT_TRUE(estimate);
    squares += std::pow(PoseDifference(estimate->pose, truth.pose)[2], 2) /
               estimate->honest_covariance(2, 2);
  }
  EXPECT_GT(std::sqrt(squares / kRuns), 0.5);
  EXPECT_LT(std::sqrt(squares / kRuns), 1.25);
}

// Orthophotos' places hold, so that the projection centre rises and sinks with all heights.
TEST(CorrelatedPoseHeights, WhatTheyHaveInCommonIsAShiftOfTheHeight) {
  std::mt19937 random(TestSeed());
  const PhotoView view = DigitalView();
  const PosePrior prior = PriorOf(view.pose, {1e4, 1}, random);
  auto observations = Observe(view, 60, true, random);
  for (PatchObservation& o : observations) o.height_sigma_m = 0;  // their surface's remain
  const auto of_orthophotos = EstimateCorrelatedPose(view, prior, observations, Common());
  ASSERT_TRUE(of_orthophotos);
  const double common_m2 = kCommonHeightShare * kHeightSigma_m * kHeightSigma_m;
  EXPECT_NEAR(of_orthophotos->common_height_covariance(2, 2), common_m2, 0.02 * common_m2);
  EXPECT_LT(of_orthophotos->common_height_covariance(0, 0), 0.02 * common_m2);
  EXPECT_LT(of_orthophotos->common_height_covariance(1, 1), 0.02 * common_m2);
  EXPECT_LT(of_orthophotos->common_height_covariance(2, 2),
            of_orthophotos->honest_covariance(2, 2));

  for (PatchObservation& o : observations) o.surface_sigma_m = 0;
  const auto of_points = EstimateCorrelatedPose(view, prior, observations, Common());
  ASSERT_TRUE(of_points);
  EXPECT_EQ(of_points->common_height_covariance.norm(), 0);
}

// What no residual shows, for the pose follows it.
TEST(CorrelatedPoseHeights, DisplacedSourcesAreInTheHonestCovariance) {
  constexpr double kSource_px = 0.8;
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> normal;
  Tally told, untold;
  for (int run = 0; run < 40; ++run) {
    const PhotoView truth = DigitalView();
    auto observations = Observe(truth, 60, false, random);
    std::array<Eigen::Matrix<double, 2, 3>, 2> errors;
    for (auto& error : errors)
      for (double& element : error.reshaped()) element = kSource_px * normal(random);
    for (PatchObservation& o : observations) {
      const Eigen::Vector2d place = (o.pixel - Eigen::Vector2d(320, 240)) / Common().half_frame_px;
      o.pixel += errors.at(static_cast<std::size_t>(o.source)) * place.homogeneous();
    }
    const PosePrior prior = PriorOf(truth.pose, kPriorSigma, random);
    PhotoView view = truth;
    view.pose = prior.pose;
    const auto without = EstimateCorrelatedPose(view, prior, observations, Common());
    for (PatchObservation& o : observations) o.source_sigma_px = kSource_px;
    const auto with = EstimateCorrelatedPose(view, prior, observations, Common());
    ASSERT_TRUE(without && with);
    EXPECT_EQ(with->pose.AsVector(), without->pose.AsVector());
    told.Add(truth, *with);
    untold.Add(truth, *without);
  }
  EXPECT_GT(told.HonestChi(), 0.7);
  EXPECT_LT(told.HonestChi(), 1.25);
  EXPECT_GT(untold.HonestChi(), 1.25);
}

}  // namespace
}  // namespace orient::exterior
