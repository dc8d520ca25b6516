#include "core/matching/least_squares_matching.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <random>
#include <stdexcept>

#include "core/raster/raster.h"
#include "core/raster/resample.h"
#include "tests/support/shared_data.h"
#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr double kNoiseFreePx = 0.01;

// image(T(p)) = template(p): the template shows the texture, the image the same moved by T.
struct Pair {
  Image templ, image;
  Eigen::Vector2d reference;
  Affine2d truth;
};

Pair MakePair(unsigned seed, const Eigen::Matrix2d& A, const Eigen::Vector2d& place, int side = 31,
              double shortest_px = 4, int image_side = 80) {
  Pair pair;
  pair.reference = Eigen::Vector2d::Constant(side / 2.0);
  pair.truth = {A, place - A * pair.reference};
  const Texture texture(seed, shortest_px);
  const Eigen::Matrix2d back = A.inverse();
  pair.templ = Draw(side, side, [&](const auto& p) { return texture.At(p); });
  pair.image = Draw(image_side, image_side,
                    [&](const auto& p) { return texture.At(back * (p - pair.truth.t)); });
  return pair;
}

Affine2d StartAt(const Pair& pair, const Eigen::Vector2d& off, const Eigen::Matrix2d& A) {
  return {A, pair.truth * pair.reference + off - A * pair.reference};
}

Eigen::Matrix2d Turned(double degrees, double scale) {
  return scale * Eigen::Rotation2Dd(degrees * std::numbers::pi / 180).toRotationMatrix();
}

const Eigen::Matrix2d kIdentity = Eigen::Matrix2d::Identity();

TEST(LeastSquaresMatching, NoiseFreeShiftsAreFoundToAHundredthOfAPixel) {
  LsmOptions options;
  options.geometry = LsmGeometry::kShift;
  double worst = 0;
  for (int i = 0; i < 20; ++i) {
    const Eigen::Vector2d place(45 + 0.05 * i, 40.5 - 0.11 * i);
    const Pair pair = MakePair(static_cast<unsigned>(i), kIdentity, place);
    const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                          StartAt(pair, {0.8, -0.7}, kIdentity), options);
    ASSERT_TRUE(result.has_value()) << i;
    worst = std::max(worst, (result->position - place).norm());
    EXPECT_GT(result->correlation, 0.999);
  }
  EXPECT_LT(worst, kNoiseFreePx);
}

TEST(LeastSquaresMatching, AffinityWithGainAndOffsetIsRecovered) {
  Eigen::Matrix2d A;
  A << 1.07, -0.12, 0.09, 0.95;
  Pair pair = MakePair(3, A, {44.3, 41.8});
  for (float& value : pair.image.values) value = 40 + 0.6f * value;
  const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                        StartAt(pair, {1, -0.6}, kIdentity));
  ASSERT_TRUE(result.has_value());
  EXPECT_LT((result->position - Eigen::Vector2d(44.3, 41.8)).norm(), kNoiseFreePx);
  EXPECT_LT((result->image_from_template.A - A).norm(), 2e-3);
  EXPECT_LT((result->image_from_template * pair.reference - result->position).norm(), 1e-9);
  EXPECT_NEAR(result->gain, 0.6, 0.01);
  EXPECT_NEAR(result->offset, 40, 1.5);
}

TEST(LeastSquaresMatching, SimilarityIsRecovered) {
  const Pair pair = MakePair(4, Turned(7, 1.05), {44.3, 41.8});
  LsmOptions options;
  options.geometry = LsmGeometry::kSimilarity;
  const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                        StartAt(pair, {0.5, 0.6}, kIdentity), options);
  ASSERT_TRUE(result.has_value());
  EXPECT_LT((result->position - Eigen::Vector2d(44.3, 41.8)).norm(), kNoiseFreePx);
  EXPECT_LT((result->image_from_template.A - pair.truth.A).norm(), 2e-3);
}

TEST(LeastSquaresMatching, StartsTurnedAndMirrored) {
  Eigen::Matrix2d mirror;
  mirror << -1, 0, 0, 1;
  for (const Eigen::Matrix2d& A : {Eigen::Matrix2d(Turned(90, 1)), Eigen::Matrix2d(Turned(180, 1)),
                                   Eigen::Matrix2d(mirror * Turned(40, 1))}) {
    for (const auto geometry : {LsmGeometry::kShift, LsmGeometry::kSimilarity}) {
      const Pair pair = MakePair(5, A, {44.3, 41.8});
      LsmOptions options;
      options.geometry = geometry;
      const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                            StartAt(pair, {0.5, 0.6}, A), options);
      ASSERT_TRUE(result.has_value());
      EXPECT_LT((result->position - Eigen::Vector2d(44.3, 41.8)).norm(), kNoiseFreePx);
    }
  }
}

TEST(LeastSquaresMatching, ReferenceNeedNotBeTheCentre) {
  Pair pair = MakePair(6, Turned(3, 1), {44.3, 41.8});
  pair.reference = {4, 27};
  const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                        StartAt(pair, {0.5, 0.6}, kIdentity));
  ASSERT_TRUE(result.has_value());
  EXPECT_LT((result->position - pair.truth * pair.reference).norm(), 2 * kNoiseFreePx);
}

TEST(LeastSquaresMatching, NanOfEitherSideTakesNoPart) {
  Pair pair = MakePair(7, Turned(2, 1.02), {44.3, 41.8});
  for (int r = 0; r < 8; ++r)
    for (int c = 0; c < 8; ++c) pair.templ.At(c, r) = kNoData;
  for (int r = 40; r < 46; ++r)
    for (int c = 50; c < 58; ++c) pair.image.At(c, r) = kNoData;
  const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                        StartAt(pair, {0.5, 0.6}, kIdentity));
  ASSERT_TRUE(result.has_value());
  EXPECT_LT((result->position - Eigen::Vector2d(44.3, 41.8)).norm(), kNoiseFreePx);
}

// RMS of the errors, each divided by what its own covariance promises, and the mean error.
struct Statistics {
  double normalised = 0, rms_px = 0, bias_px = 0;
  int found = 0;
};

Statistics MonteCarlo(LsmGeometry geometry, double templ_noise, double image_noise, int runs,
                      const Eigen::Vector2d& place) {
  std::mt19937 random(TestSeed());
  LsmOptions options;
  options.geometry = geometry;
  Statistics s;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (int i = 0; i < runs; ++i) {
    Pair pair = MakePair(static_cast<unsigned>(100 + i), kIdentity, place, 25, 4, 46);
    pair.templ = WithNoise(pair.templ, templ_noise, &random);
    pair.image = WithNoise(pair.image, image_noise, &random);
    const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                          StartAt(pair, {0.4, -0.3}, kIdentity), options);
    if (!result) continue;
    const Eigen::Vector2d error = result->position - place;
    s.normalised += error.dot(result->covariance.inverse() * error) / 2;
    s.rms_px += error.squaredNorm() / 2;
    mean += error;
    ++s.found;
  }
  s.normalised = std::sqrt(s.normalised / s.found);
  s.rms_px = std::sqrt(s.rms_px / s.found);
  s.bias_px = (mean / s.found).norm();
  return s;
}

struct NoiseCase {
  LsmGeometry geometry;
  double templ_noise, image_noise;
  Eigen::Vector2d place;
};

class LsmCovariance : public testing::TestWithParam<NoiseCase> {};

TEST_P(LsmCovariance, IsHonest) {
  const NoiseCase& c = GetParam();
  constexpr int kRuns = 200;
  const Statistics s = MonteCarlo(c.geometry, c.templ_noise, c.image_noise, kRuns, c.place);
  RecordProperty("normalised", std::to_string(s.normalised));
  RecordProperty("rms_px", std::to_string(s.rms_px));
  EXPECT_GE(s.found, kRuns * 95 / 100);
  EXPECT_GT(s.normalised, 0.85);
  EXPECT_LT(s.normalised, 1.2);
  // The mean of that many: four of its own deviations.
  EXPECT_LT(s.bias_px, 4 * s.rms_px * std::sqrt(2.0 / kRuns) + 0.002);
}

INSTANTIATE_TEST_SUITE_P(Noise, LsmCovariance,
                         testing::Values(NoiseCase{LsmGeometry::kShift, 5, 5, {22.37, 23.62}},
                                         NoiseCase{LsmGeometry::kShift, 5, 5, {22.0, 23.0}},
                                         NoiseCase{LsmGeometry::kShift, 5, 5, {22.75, 23.25}},
                                         NoiseCase{LsmGeometry::kShift, 15, 15, {22.75, 23.25}},
                                         NoiseCase{LsmGeometry::kAffine, 5, 5, {22.37, 23.62}},
                                         NoiseCase{LsmGeometry::kAffine, 15, 15, {22.25, 23.75}},
                                         NoiseCase{LsmGeometry::kAffine, 0, 10, {22.25, 23.75}},
                                         NoiseCase{
                                             LsmGeometry::kSimilarity, 10, 0, {22.25, 23.75}}));

// blur_px 0: a sharp edge over the pixels' areas.
Image EdgeImage(int width, int height, const Eigen::Vector2d& offset, double blur_px) {
  const Eigen::Vector2d normal = Eigen::Vector2d(1, 0.4).normalized();
  return DrawArea(width, height, 8, [&](const Eigen::Vector2d& p) {
    const double distance = normal.dot(p - offset) - 17;
    if (blur_px == 0) return distance > 0 ? 200.0 : 60.0;
    return 130 + 70 * std::erf(distance / (std::numbers::sqrt2 * blur_px));
  });
}

TEST(LeastSquaresMatchingEdge, SingularDirectionIsNoMatch) {
  std::mt19937 random(TestSeed());
  for (const double blur : {0.0, 0.7, 2.0}) {
    for (const double noise : {0.0, 0.5, 2.0, 10.0}) {
      for (const auto geometry : {LsmGeometry::kShift, LsmGeometry::kAffine}) {
        const Image templ = WithNoise(EdgeImage(25, 25, {0, 0}, blur), noise, &random);
        const Image image = WithNoise(EdgeImage(60, 60, {17.3, 16.8}, blur), noise, &random);
        LsmOptions options;
        options.geometry = geometry;
        EXPECT_FALSE(MatchLeastSquares(templ, image, {12.5, 12.5}, {kIdentity, {17, 17}}, options))
            << blur << " " << noise;
      }
    }
  }
}

// Asked for edges, it is one across its direction: there the shift is right, and its precision
// holds; along it nothing moves, and nothing is claimed.
TEST(LeastSquaresMatchingEdge, IsAMatchAcrossItsDirectionWhereAsked) {
  std::mt19937 random(TestSeed());
  const Eigen::Vector2d normal = Eigen::Vector2d(1, 0.4).normalized();
  const Eigen::Vector2d direction(-normal.y(), normal.x());
  const Eigen::Vector2d reference(12.5, 12.5), start(17, 17), shift(17.3, 16.8);
  LsmOptions options;
  options.geometry = LsmGeometry::kShift;
  options.edges = true;
  double squares = 0;
  constexpr int kRuns = 60;
  for (int run = 0; run < kRuns; ++run) {
    const Image templ = WithNoise(EdgeImage(25, 25, {0, 0}, 1.5), 2, &random);
    const Image image = WithNoise(EdgeImage(60, 60, shift, 1.5), 2, &random);
    const auto fit = MatchLeastSquares(templ, image, reference, {kIdentity, start}, options);
    ASSERT_TRUE(fit);
    ASSERT_TRUE(fit->along);
    EXPECT_NEAR(std::abs(fit->along->dot(direction)), 1, 1e-3);
    const Eigen::Vector2d off = fit->position - reference - shift;
    EXPECT_NEAR((fit->position - reference - start).dot(*fit->along), 0, 1e-6);
    EXPECT_GT(std::sqrt(direction.dot(fit->covariance * direction)), 0.9 * kOpenAlongEdge_px);
    const Eigen::Vector2d across(-fit->along->y(), fit->along->x());
    squares += std::pow(across.dot(off), 2) / across.dot(fit->covariance * across);
  }
  EXPECT_LT(std::sqrt(squares / kRuns), 1.3);
  EXPECT_GT(std::sqrt(squares / kRuns), 0.6);
}

TEST(LeastSquaresMatchingFlat, FlatSideIsNoMatch) {
  const Pair pair = MakePair(1, kIdentity, {45, 40});
  const Affine2d start = StartAt(pair, {0, 0}, kIdentity);
  EXPECT_FALSE(MatchLeastSquares(Image(31, 31, 9), pair.image, pair.reference, start));
  EXPECT_FALSE(MatchLeastSquares(pair.templ, Image(90, 80, 9), pair.reference, start));
  EXPECT_FALSE(MatchLeastSquares(Image(31, 31, kNoData), pair.image, pair.reference, start));
  EXPECT_FALSE(MatchLeastSquares(Image(), pair.image, pair.reference, start));
  EXPECT_FALSE(MatchLeastSquares(pair.templ, Image(), pair.reference, start));
}

TEST(LeastSquaresMatchingFlat, FlatWithNoiseIsNoMatch) {
  std::mt19937 random(TestSeed());
  int found = 0;
  for (int i = 0; i < 50; ++i)
    if (MatchLeastSquares(WithNoise(Image(25, 25, 90), 4, &random),
                          WithNoise(Image(60, 60, 90), 4, &random), {12.5, 12.5},
                          {kIdentity, {17, 17}}))
      ++found;
  EXPECT_LE(found, 1);
}

TEST(LeastSquaresMatchingDiverging, WrongPlaceIsNoMatchOrTellsByItsCorrelation) {
  int convincing = 0;
  for (unsigned seed = 0; seed < 30; ++seed) {
    const Pair pair = MakePair(seed, kIdentity, {45, 40});
    const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                          StartAt(pair, {14, -11}, kIdentity));
    if (result && result->correlation > 0.8) ++convincing;
  }
  EXPECT_EQ(convincing, 0);
}

TEST(LeastSquaresMatchingDiverging, ShiftBeyondTheLimitIsNoMatch) {
  const Pair pair = MakePair(2, kIdentity, {45, 40}, 31, 12);
  LsmOptions options;
  options.max_shift_px = 1;
  const Affine2d start = StartAt(pair, {1.6, 0}, kIdentity);
  EXPECT_FALSE(MatchLeastSquares(pair.templ, pair.image, pair.reference, start, options));
  options.max_shift_px = 3;
  EXPECT_TRUE(MatchLeastSquares(pair.templ, pair.image, pair.reference, start, options));
}

TEST(LeastSquaresMatchingDiverging, DeformationBeyondTheLimitIsNoMatch) {
  const Pair pair = MakePair(2, Turned(6, 1.05), {45, 40}, 31, 8);
  LsmOptions options;
  options.max_deformation = 0.05;
  const Affine2d start = StartAt(pair, {0.3, 0}, kIdentity);
  EXPECT_FALSE(MatchLeastSquares(pair.templ, pair.image, pair.reference, start, options));
  options.max_deformation = 0.3;
  EXPECT_TRUE(MatchLeastSquares(pair.templ, pair.image, pair.reference, start, options));
}

TEST(LeastSquaresMatchingOutside, TooFewPixelsInTheImageIsNoMatch) {
  const Pair pair = MakePair(2, kIdentity, {45, 40});
  for (const Eigen::Vector2d& place : {Eigen::Vector2d(2, 40), Eigen::Vector2d(-500, 40),
                                       Eigen::Vector2d(89, 79), Eigen::Vector2d(1e12, 0)})
    EXPECT_FALSE(MatchLeastSquares(pair.templ, pair.image, pair.reference,
                                   {kIdentity, place - pair.reference}));
}

TEST(LeastSquaresMatching, SingularStartIsTheCallersFault) {
  const Pair pair = MakePair(2, kIdentity, {45, 40});
  EXPECT_THROW(
      MatchLeastSquares(pair.templ, pair.image, pair.reference, {Eigen::Matrix2d::Zero(), {0, 0}}),
      std::invalid_argument);
}

TEST(LeastSquaresMatching, WithoutRadiometryGreyValuesMustAgree) {
  Pair pair = MakePair(2, kIdentity, {45.3, 40.6});
  LsmOptions options;
  options.radiometric = false;
  const Affine2d start = StartAt(pair, {0.3, 0}, kIdentity);
  const auto result = MatchLeastSquares(pair.templ, pair.image, pair.reference, start, options);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->gain, 1);
  EXPECT_EQ(result->offset, 0);
  EXPECT_LT((result->position - Eigen::Vector2d(45.3, 40.6)).norm(), kNoiseFreePx);
}

// Blurred before it is reduced: without, the grain beyond the new Nyquist limit folds back and
// pulls a match by up to 0.05 px, whatever the interpolation.
Image ReducedBand(const Raster& raster, int col, int row, int size) {
  constexpr int kMargin = 20;
  const Image full =
      raster.ReadGrey({col - kMargin, row - kMargin, size + 2 * kMargin, size + 2 * kMargin}).image;
  const Image reduced = ReduceBy(GaussianBlur(full, 3.0), 4);
  return Crop(reduced, kMargin / 4, kMargin / 4, size / 4, size / 4);
}

TEST(RealLeastSquaresMatching, ReducedScanMovedByAQuarterPixel) {
  ORIENT_REQUIRE_SHARED_DATA(path, "film/0bbe1004.jpg");
  const Raster raster = Raster::Open(path);
  constexpr double kRealPx = 0.01;  // of the reduced image
  LsmOptions options;
  options.geometry = LsmGeometry::kShift;
  int found = 0;
  double worst = 0;
  for (int k = 0; k < 24; ++k) {
    const int col = 600 + 300 * (k % 6), row = 600 + 400 * (k / 6), dx = k % 4, dy = (k / 4) % 4;
    const Image templ = ReducedBand(raster, col, row, 120);
    const Image image = ReducedBand(raster, col - 40 + dx, row - 40 + dy, 200);
    const auto result =
        MatchLeastSquares(templ, image, {15, 15}, {kIdentity, {10.4, 9.7}}, options);
    if (!result) continue;
    ++found;
    const Eigen::Vector2d truth(25 - dx / 4.0, 25 - dy / 4.0);
    worst = std::max(worst, (result->position - truth).norm());
  }
  EXPECT_GE(found, 18);
  EXPECT_LT(worst, kRealPx);
}

}  // namespace
}  // namespace orient
