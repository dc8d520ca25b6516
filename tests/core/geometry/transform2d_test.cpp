#include "core/geometry/transform2d.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>

#include "tests/support/generators.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr double kExact = 1e-12;
constexpr double kClosedForm = 1e-9;

rc::Gen<Affine2d> AnyAffine() {
  return rc::gen::exec([] {
    Affine2d transform;
    const double turn = *InRange(-3, 3), shear = *InRange(-0.5, 0.5), scale = *InRange(0.1, 3);
    Eigen::Matrix2d rotation, sheared;
    rotation << std::cos(turn), -std::sin(turn), std::sin(turn), std::cos(turn);
    sheared << scale, shear, 0, *rc::gen::element(-1.0, 1.0) * scale;
    transform.A = rotation * sheared;
    transform.t = {*InRange(-1e4, 1e4), *InRange(-1e4, 1e4)};
    return transform;
  });
}

rc::Gen<Eigen::Vector2d> AnyPoint() {
  return rc::gen::exec([] { return Eigen::Vector2d(*InRange(0, 1e4), *InRange(0, 1e4)); });
}

std::vector<PointPair2d> PairsOf(const Affine2d& transform,
                                 const std::vector<Eigen::Vector2d>& sources) {
  std::vector<PointPair2d> pairs;
  for (const auto& source : sources) pairs.push_back({source, transform * source});
  return pairs;
}

const std::vector<Eigen::Vector2d> kMarks = {{300, 280},  {9000, 310},  {8950, 9020}, {320, 8990},
                                             {4600, 250}, {9100, 4580}, {4620, 9100}, {260, 4610}};

TEST(Affine2d, TheInverseLeadsBack) {
  EXPECT_TRUE(rc::check("inverse", [] {
    const Affine2d transform = *AnyAffine();
    const Eigen::Vector2d point = *AnyPoint();
    RC_ASSERT((transform.Inverse() * (transform * point) - point).norm() < kClosedForm * 100);
  }));
}

TEST(Affine2d, AProductAppliesTheRightFactorFirst) {
  EXPECT_TRUE(rc::check("composition", [] {
    const Affine2d a = *AnyAffine(), b = *AnyAffine();
    const Eigen::Vector2d point = *AnyPoint();
    RC_ASSERT(((a * b) * point - a * (b * point)).norm() < kClosedForm * 100);
  }));
}

TEST(Affine2d, SingularHasNoInverse) {
  Affine2d flat;
  flat.A << 1, 2, 2, 4;
  EXPECT_THROW(flat.Inverse(), std::invalid_argument);
  EXPECT_THROW((Affine2d{Eigen::Matrix2d::Zero(), {0, 0}}).Inverse(), std::invalid_argument);
}

TEST(FitAffine, FindsTheExactTransform) {
  EXPECT_TRUE(rc::check("affine from exact pairs", [] {
    const Affine2d truth = *AnyAffine();
    const auto fit = FitAffine(PairsOf(truth, kMarks));
    RC_ASSERT(fit.has_value());
    RC_ASSERT((fit->transform.A - truth.A).norm() < kClosedForm);
    RC_ASSERT((fit->transform.t - truth.t).norm() < kClosedForm * 1e4);
    RC_ASSERT(fit->redundancy == 10);
    RC_ASSERT(fit->sigma0 < kClosedForm * 1e2);
  }));
}

TEST(FitAffine, ResidualIsMeasuredMinusComputed) {
  // Four corners of a square, one target moved by +4 in x: the affine takes +-1 at each corner.
  std::vector<PointPair2d> pairs = PairsOf({}, {{0, 0}, {10, 0}, {10, 10}, {0, 10}});
  pairs[0].target.x() += 4;
  const auto fit = FitAffine(pairs);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->residuals[0].x(), 1, kExact);
  EXPECT_NEAR(fit->residuals[1].x(), -1, kExact);
  EXPECT_EQ(fit->redundancy, 2);
  EXPECT_NEAR(fit->sigma0, std::sqrt(4.0 / 2.0), kExact);  // sqrt(v'v / (2n - 6))
}

TEST(FitAffine, ThreePairsHaveNoResidualsAndTheSigmaOfThePairs) {
  std::vector<PointPair2d> pairs = PairsOf({}, {{0, 0}, {100, 0}, {0, 100}});
  for (auto& pair : pairs) pair.sigma = 0.5;
  const auto fit = FitAffine(pairs);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->redundancy, 0);
  EXPECT_EQ(fit->sigma0, 0);
  // At a mark the transformed point is as uncertain as the mark.
  EXPECT_LT((fit->CovarianceAt({100, 0}) - 0.25 * Eigen::Matrix2d::Identity()).norm(), kExact);
}

TEST(FitAffine, TwoPairsAreTooFew) { EXPECT_FALSE(FitAffine(PairsOf({}, {{0, 0}, {1, 0}}))); }

TEST(FitAffine, CollinearSourcesHaveNoAffine) {
  EXPECT_FALSE(FitAffine(PairsOf({}, {{0, 0}, {1, 1}, {2, 2}, {5, 5}})));
  EXPECT_FALSE(
      FitAffine(PairsOf({}, {{1e6, 1e6}, {1e6 + 0.1, 1e6 + 0.3}, {1e6 + 0.2, 1e6 + 0.6}})));
}

TEST(FitAffine, CoincidentSourcesHaveNoAffine) {
  EXPECT_FALSE(FitAffine(PairsOf({}, {{7, 7}, {7, 7}, {7, 7}})));
}

TEST(FitAffine, ASigmaThatIsNotPositiveIsABrokenPromise) {
  std::vector<PointPair2d> pairs = PairsOf({}, kMarks);
  pairs[2].sigma = 0;
  EXPECT_THROW(FitAffine(pairs), std::invalid_argument);
}

TEST(FitSimilarity, FindsTheExactTransformOfBothHandednesses) {
  EXPECT_TRUE(rc::check("similarity from exact pairs", [] {
    const double a = *InRange(-2, 2), b = *InRange(0.1, 2);
    const bool mirrored = *rc::gen::arbitrary<bool>();
    Affine2d truth;
    if (mirrored)
      truth.A << a, b, b, -a;
    else
      truth.A << a, -b, b, a;
    truth.t = {3, -7};
    const auto fit = FitSimilarity(PairsOf(truth, kMarks), mirrored);
    RC_ASSERT(fit.has_value());
    RC_ASSERT((fit->transform.A - truth.A).norm() < kClosedForm);
    RC_ASSERT((fit->transform.t - truth.t).norm() < kClosedForm * 1e4);
    // The other handedness does not explain the marks.
    RC_ASSERT(FitSimilarity(PairsOf(truth, kMarks), !mirrored)->sigma0 > 100);
  }));
}

TEST(FitSimilarity, TwoPairsAreEnoughUnlessTheyCoincide) {
  EXPECT_TRUE(FitSimilarity(PairsOf({}, {{0, 0}, {1, 0}}), false));
  EXPECT_FALSE(FitSimilarity(PairsOf({}, {{1, 0}, {1, 0}}), false));
  EXPECT_FALSE(FitSimilarity(PairsOf({}, {{1, 0}}), false));
}

// Root mean square of normalised errors over many noisy fits: 1 when the covariance is right.
template <class Fit, class Parameters>
double NormalisedErrorRms(const Affine2d& truth, Fit fit, Parameters parameters) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> noise(0, 0.004);
  double sum = 0, count = 0;
  for (int run = 0; run < 2000; ++run) {
    std::vector<PointPair2d> pairs;
    for (int i = 0; i < 25; ++i) {
      const int row = i / 5, column = i % 5;
      const Eigen::Vector2d source(9000.0 * column / 4, 9000.0 * row / 4);
      const double sigma = i % 2 == 0 ? 1.0 : 3.0;
      const Eigen::Vector2d error(sigma * noise(random), sigma * noise(random));
      pairs.push_back({source, truth * source + error, sigma});
    }
    const auto result = fit(pairs);
    const Eigen::VectorXd error = parameters(result->transform) - parameters(truth);
    sum += error.dot(result->covariance.ldlt().solve(error));
    count += static_cast<double>(error.size());
  }
  return std::sqrt(sum / count);
}

TEST(FitAffine, CovarianceIsTheScatterOfManyFits) {
  Affine2d truth;
  truth.A << 0.025, 0.0003, -0.0001, -0.0249;
  truth.t = {-115, 114};
  const double rms = NormalisedErrorRms(truth, FitAffine, [](const Affine2d& t) {
    return (Eigen::VectorXd(6) << t.A(0, 0), t.A(0, 1), t.A(1, 0), t.A(1, 1), t.t).finished();
  });
  EXPECT_NEAR(rms, 1.0, 0.05);  // 44 degrees of freedom in sigma0 raise it by 2 %
}

TEST(FitSimilarity, CovarianceIsTheScatterOfManyFits) {
  Affine2d truth;
  truth.A << 0.0003, -0.025, -0.025, -0.0003;
  truth.t = {115, 114};
  const double rms = NormalisedErrorRms(
      truth, [](const auto& pairs) { return FitSimilarity(pairs, true); },
      [](const Affine2d& t) {
        return (Eigen::VectorXd(4) << t.A(0, 0), t.A(0, 1), t.t).finished();
      });
  EXPECT_NEAR(rms, 1.0, 0.05);
}

TEST(TransformFit, CovarianceAtIsThePropagatedCovariance) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<double> noise(0, 0.004);
  for (const bool affine : {true, false}) {
    Affine2d truth;
    truth.A << 0, 0.025, 0.025, 0;
    const Eigen::Vector2d place(11000, -500);
    double sum = 0;
    constexpr int kRuns = 2000;
    for (int run = 0; run < kRuns; ++run) {
      auto pairs = PairsOf(truth, kMarks);
      for (auto& pair : pairs) pair.target += Eigen::Vector2d(noise(random), noise(random));
      const auto fit = affine ? FitAffine(pairs) : FitSimilarity(pairs, true);
      const Eigen::Vector2d error = fit->transform * place - truth * place;
      sum += error.dot(fit->CovarianceAt(place).ldlt().solve(error)) / 2;
    }
    EXPECT_NEAR(std::sqrt(sum / kRuns), 1.0, 0.15);  // 10 degrees of freedom raise it by 12 %
  }
}

// The positive, seen as the camera saw the ground, shows   a b c
//                                                         d e f
// Each scan below was written by hand: the picture turned, or mirrored and then turned.
struct Scan {
  ScanOrientation orientation;
  std::vector<std::string> rows;
};
const std::vector<Scan> kScans = {
    {ScanOrientation::kR0, {"abc", "def"}},   {ScanOrientation::kR90, {"cf", "be", "ad"}},
    {ScanOrientation::kR180, {"fed", "cba"}}, {ScanOrientation::kR270, {"da", "eb", "fc"}},
    {ScanOrientation::kM0, {"cba", "fed"}},   {ScanOrientation::kM90, {"ad", "be", "cf"}},
    {ScanOrientation::kM180, {"def", "abc"}}, {ScanOrientation::kM270, {"fc", "eb", "da"}}};

Eigen::Vector2d PhotoPlaceOf(char letter) {  // x right, y up, origin in the middle
  const int i = letter - 'a';
  return {i % 3 - 1.0, i < 3 ? 0.5 : -0.5};
}

TEST(ScanOrientation, AxesPutEveryLetterOfATinyPictureInItsPlace) {
  for (const Scan& scan : kScans) {
    const Eigen::Matrix2d axes = PhotoFromPixelAxes(scan.orientation);
    const double height = static_cast<double>(scan.rows.size());
    const double width = static_cast<double>(scan.rows[0].size());
    for (std::size_t row = 0; row < scan.rows.size(); ++row) {
      for (std::size_t col = 0; col < scan.rows[row].size(); ++col) {
        const Eigen::Vector2d from_middle(static_cast<double>(col) + 0.5 - width / 2,
                                          static_cast<double>(row) + 0.5 - height / 2);
        EXPECT_LT((axes * from_middle - PhotoPlaceOf(scan.rows[row][col])).norm(), kExact)
            << Name(scan.orientation) << " letter " << scan.rows[row][col];
      }
    }
  }
}

TEST(ScanOrientation, MirroredScansHavePositiveDeterminant) {
  for (const ScanOrientation orientation : kAllScanOrientations)
    EXPECT_EQ(PhotoFromPixelAxes(orientation).determinant() > 0, IsMirrored(orientation));
}

TEST(ScanOrientation, NamesComeBack) {
  for (const ScanOrientation orientation : kAllScanOrientations)
    EXPECT_EQ(ScanOrientationFromName(Name(orientation)), orientation);
  EXPECT_EQ(Name(ScanOrientation::kM270), "m270");
  EXPECT_FALSE(ScanOrientationFromName("r45"));
  EXPECT_FALSE(ScanOrientationFromName(""));
}

TEST(ScanOrientation, NearestSurvivesFilmDeformationAndTurnsUpToFortyDegrees) {
  EXPECT_TRUE(rc::check("nearest orientation", [] {
    const ScanOrientation orientation = *rc::gen::elementOf(kAllScanOrientations);
    const double turn = *InRange(-0.7, 0.7);
    Eigen::Matrix2d deformation;
    deformation << std::cos(turn), -std::sin(turn), std::sin(turn), 1.01 * std::cos(turn);
    const Affine2d photo_from_pixel = {0.02 * deformation * PhotoFromPixelAxes(orientation),
                                       {*InRange(-200, 200), *InRange(-200, 200)}};
    RC_ASSERT(NearestScanOrientation(photo_from_pixel) == orientation);
  }));
}

}  // namespace
}  // namespace orient
