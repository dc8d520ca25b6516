#include "block/roll/camera_estimation.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "core/geometry/transform2d.h"

namespace orient::block {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

const std::vector<Vector2d> kNominal = {{-106, -106}, {106, 106}, {-106, 106}, {106, -106},
                                        {-110, 0},    {110, 0},   {0, 110},    {0, -110}};

struct RollSpec {
  int scans = 20;
  double camera_error_mm = 0.02;  // of the true positions around the nominal ones
  double noise_mm = 0.003;        // measuring and film
  double film_affinity = 1e-4;    // scan to scan
  double common_affinity = 0;     // of the scanner, one sigma
  double missing = 0.1;
  double wrong = 0;  // sightings off by 0.1 to 1 mm
  unsigned seed = 1;
};

struct Roll {
  std::vector<Vector2d> truth;
  std::vector<ScanOfMarks> scans;
};

Roll Simulate(const RollSpec& spec) {
  std::mt19937 random(spec.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  Roll roll;
  for (const Vector2d& p : kNominal)
    roll.truth.push_back(p + spec.camera_error_mm * Vector2d(normal(random), normal(random)));
  const Vector2d common = spec.common_affinity * Vector2d(normal(random), normal(random));
  for (int s = 0; s < spec.scans; ++s) {
    const Vector2d a = common + spec.film_affinity * Vector2d(normal(random), normal(random));
    Eigen::Matrix2d film;
    film << 1 + 0.5 * a.x(), 0.5 * a.y(), 0.5 * a.y(), 1 - 0.5 * a.x();
    film *= 1 + 0.003 * normal(random);
    const Eigen::Matrix2d turn =
        Eigen::Rotation2Dd(0.01 * normal(random)).toRotationMatrix() * film;
    const Vector2d shift(3 * normal(random), 3 * normal(random));
    ScanOfMarks scan{std::to_string(s), {}};
    for (const Vector2d& p : roll.truth) {
      Vector2d place = turn * p + shift + spec.noise_mm * Vector2d(normal(random), normal(random));
      if (unit(random) < spec.wrong) {
        const double angle = 6.28 * unit(random);
        place += (0.1 + 0.9 * unit(random)) * Vector2d(std::cos(angle), std::sin(angle));
      }
      if (unit(random) < spec.missing)
        scan.place_mm.emplace_back();
      else
        scan.place_mm.emplace_back(place);
    }
    roll.scans.push_back(std::move(scan));
  }
  return roll;
}

// The truth as the start positions' shift, turn and scale (and affinity) show it: what the estimate
// claims to be.
std::vector<Vector2d> InGauge(const std::vector<Vector2d>& truth, CommonAffinity common) {
  std::vector<PointPair2d> pairs;
  for (size_t i = 0; i < truth.size(); ++i) pairs.push_back({truth[i], kNominal[i]});
  const Affine2d map = common == CommonAffinity::kUnknown ? FitAffine(pairs)->transform
                                                          : FitSimilarity(pairs, false)->transform;
  std::vector<Vector2d> mapped;
  for (const Vector2d& p : truth) mapped.push_back(map * p);
  return mapped;
}

struct Quality {
  double normalised = 0;  // RMS over coordinates and rolls
  double error_mm = 0;    // RMS of a coordinate
  int estimates = 0;
};

Quality MonteCarlo(RollSpec spec, CommonAffinity common, int rolls) {
  Quality quality;
  double normalised = 0, squares = 0;
  long count = 0;
  for (int i = 0; i < rolls; ++i) {
    spec.seed = static_cast<unsigned>(i + 1);
    const Roll roll = Simulate(spec);
    const auto estimate = EstimateCamera(roll.scans, kNominal, common);
    if (!estimate) continue;
    ++quality.estimates;
    const std::vector<Vector2d> truth = InGauge(roll.truth, common);
    for (size_t k = 0; k < truth.size(); ++k) {
      const Vector2d error = estimate->position_mm[k] - truth[k];
      normalised += error.cwiseQuotient(estimate->sigma_mm[k]).squaredNorm();
      squares += error.squaredNorm();
      count += 2;
    }
  }
  quality.normalised = std::sqrt(normalised / static_cast<double>(count));
  quality.error_mm = std::sqrt(squares / static_cast<double>(count));
  return quality;
}

TEST(CameraEstimation, ErrorsAreAsLargeAsTheirSigmasSay) {
  RollSpec desktop;
  desktop.common_affinity = 0.008;
  const Quality unknown = MonteCarlo(desktop, CommonAffinity::kUnknown, 60);
  EXPECT_EQ(unknown.estimates, 60);
  EXPECT_GT(unknown.normalised, 0.8);
  EXPECT_LT(unknown.normalised, 1.25);
  EXPECT_LT(unknown.error_mm, 0.0015) << "20 scans of 3 um each, nominal positions off by 20 um";

  RollSpec photogrammetric;
  photogrammetric.common_affinity = 1.5e-4;
  const Quality small = MonteCarlo(photogrammetric, CommonAffinity::kSmall, 150);
  EXPECT_GT(small.normalised, 0.8);
  EXPECT_LT(small.normalised, 1.25);
}

TEST(CameraEstimation, FewScansAreHonestToo) {
  RollSpec spec;
  spec.scans = 5;
  spec.missing = 0;
  const Quality quality = MonteCarlo(spec, CommonAffinity::kUnknown, 120);
  EXPECT_GT(quality.normalised, 0.8);
  EXPECT_LT(quality.normalised, 1.25);
}

TEST(CameraEstimation, WrongSightingsAreThrownOut) {
  RollSpec spec;
  spec.wrong = 0.08;
  const Quality quality = MonteCarlo(spec, CommonAffinity::kUnknown, 30);
  EXPECT_LT(quality.error_mm, 0.0015);
  EXPECT_GT(quality.normalised, 0.8);
  EXPECT_LT(quality.normalised, 1.25);
}

TEST(CameraEstimation, NoiseAndTheFilmsAffinityComeOut) {
  RollSpec spec;
  spec.scans = 100;
  spec.film_affinity = 4e-4;
  spec.common_affinity = 0.01;
  const Roll roll = Simulate(spec);
  const auto estimate = EstimateCamera(roll.scans, kNominal, CommonAffinity::kUnknown);
  ASSERT_TRUE(estimate);
  EXPECT_NEAR(estimate->noise_um, 3, 0.3);
  EXPECT_NEAR(estimate->affinity, 4e-4, 8e-5);
  EXPECT_EQ(estimate->scans, 100);
}

TEST(CameraEstimation, AMarkThatNoScanShowsHasNoPrecision) {
  Roll roll = Simulate({});
  for (ScanOfMarks& scan : roll.scans) scan.place_mm[6].reset();
  const auto estimate = EstimateCamera(roll.scans, kNominal, CommonAffinity::kUnknown);
  ASSERT_TRUE(estimate);
  EXPECT_TRUE(std::isinf(estimate->sigma_mm[6].x()));
  EXPECT_EQ(estimate->position_mm[6], kNominal[6]);
  EXPECT_LT(estimate->sigma_mm[0].x(), 0.01);
}

// Two scans show the last mark, each with two that nobody else shows: they say nothing of it.
TEST(CameraEstimation, AMarkOfScansThatTellNothingHasNoPrecision) {
  std::vector<Vector2d> nominal = kNominal;
  nominal.resize(8);
  nominal.emplace_back(0, 50);
  std::vector<ScanOfMarks> scans;
  const auto add = [&](const std::vector<std::size_t>& marks) {
    ScanOfMarks scan{std::to_string(scans.size()), {}};
    scan.place_mm.resize(nominal.size());
    for (const std::size_t i : marks)
      scan.place_mm[i] = nominal[i] + 0.002 * Vector2d((i + scans.size()) % 3, scans.size() % 2);
    scans.push_back(std::move(scan));
  };
  for (int i = 0; i < 6; ++i) add({0, 1, 2, 3});
  add({8, 4, 5});
  add({8, 6, 7});
  const auto estimate = EstimateCamera(scans, nominal, CommonAffinity::kUnknown);
  ASSERT_TRUE(estimate);
  EXPECT_EQ(estimate->scans, 6);
  EXPECT_TRUE(std::isinf(estimate->sigma_mm[8].x()));
  EXPECT_TRUE(std::isfinite(estimate->sigma_mm[0].x()));
}

TEST(CameraEstimation, TwoScansOrThreeMarksAreTooFew) {
  RollSpec spec;
  spec.scans = 2;
  spec.missing = 0;
  EXPECT_FALSE(EstimateCamera(Simulate(spec).scans, kNominal, CommonAffinity::kUnknown));
  spec.scans = 10;
  Roll roll = Simulate(spec);
  for (ScanOfMarks& scan : roll.scans)
    for (size_t i = 3; i < scan.place_mm.size(); ++i) scan.place_mm[i].reset();
  EXPECT_FALSE(EstimateCamera(roll.scans, kNominal, CommonAffinity::kUnknown));
  roll.scans[0].place_mm.pop_back();
  EXPECT_THROW(EstimateCamera(roll.scans, kNominal, CommonAffinity::kUnknown),
               std::invalid_argument);
}

}  // namespace
}  // namespace orient::block
