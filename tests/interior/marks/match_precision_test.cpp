#include "interior/marks/match_precision.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/raster/resample.h"
#include "tests/support/shared_data.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;

constexpr double kNoise = 5;

Image Spot(double brightness) {
  Image image(41, 41);
  for (int r = 0; r < 41; ++r)
    for (int c = 0; c < 41; ++c)
      image.At(c, r) = static_cast<float>(
          brightness * std::exp(-0.5 * (std::pow(c - 20, 2) + std::pow(r - 20, 2)) / 9));
  return image;
}

// The mean of the predicted variance of x over a number of noisy spots.
double PredictedVariance(double blur_px, double* noise_sigma) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> normal(0, 1);
  const Image spot = Spot(1);
  double sum = 0, squares = 0;
  constexpr int kTrials = 50;
  for (int trial = 0; trial < kTrials; ++trial) {
    Image noise(41, 41);
    for (float& v : noise.values) v = static_cast<float>(kNoise) * normal(random);
    if (blur_px > 0) noise = GaussianBlur(noise, blur_px);
    Image seen = Spot(200);
    for (size_t i = 0; i < seen.values.size(); ++i) seen.values[i] += noise.values[i];
    for (const float v : noise.values) squares += static_cast<double>(v * v);
    sum += PrecisionOfMatch(seen, spot, Vector2d::Zero())->covariance(0, 0);
  }
  *noise_sigma = std::sqrt(squares / (kTrials * 41.0 * 41.0));
  return sum / kTrials;
}

// Sum of the squared gradient of a Gaussian spot in one direction: pi A^2 / 2.
const double kInformation = std::acos(-1.0) / 2 * 200 * 200;

TEST(PrecisionOfMatch, IsTheTextbooksForIndependentNoise) {
  double sigma = 0;
  const double variance = PredictedVariance(0, &sigma);
  EXPECT_NEAR(variance / (sigma * sigma / kInformation), 1.0, 0.15);  // few spots, finite lags
}

TEST(PrecisionOfMatch, GrowsWhereNeighboursErrTogether) {
  double sigma = 0;
  const double variance = PredictedVariance(0.8, &sigma);
  // Against a wide spot, correlated noise counts with its sum over all lags: 4 pi blur^2.
  const double factor = 4 * std::acos(-1.0) * 0.64;
  const double ratio = variance / (sigma * sigma / kInformation);
  EXPECT_GT(ratio, 0.6 * factor);
  EXPECT_LT(ratio, 1.1 * factor);
}

// Grain half as strong as the spot's top: the correlation is 0.25, and the drawing explains the
// rest.
TEST(PrecisionOfMatch, WithoutItsGrainAFaintSpotIsWhatIsDrawn) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> grain(0, 20);
  Image seen = Spot(40);
  for (float& value : seen.values) value += grain(random);
  const auto match = PrecisionOfMatch(seen, Spot(1), Vector2d::Zero());
  EXPECT_GT(match->correlation_without_grain, 0.75);
  EXPECT_EQ(CorrelationWithoutGrain(seen, Spot(1), Vector2d::Zero(), 25),
            match->correlation_without_grain);
  EXPECT_FALSE(CorrelationWithoutGrain(seen, Spot(1), Vector2d::Zero(), 15));
  EXPECT_GT(match->gain_over_sigma, 7);  // 40 sqrt(9 pi) / 20 = 10.6 and its scatter
}

TEST(PrecisionOfMatch, AnotherDrawingIsNoGrain) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> grain(0, 2);
  Image seen(41, 41);
  for (int r = 0; r < 41; ++r)
    for (int c = 0; c < 41; ++c)  // an upright cross with arms of three pixels
      seen.At(c, r) =
          (std::abs(c - 20) <= 1 || std::abs(r - 20) <= 1 ? 40.0f : 0.0f) + grain(random);
  EXPECT_LT(PrecisionOfMatch(seen, Spot(1), Vector2d::Zero())->correlation_without_grain, 0.65);
}

TEST(PrecisionOfMatch, GainOfGrainAloneIsAsLargeAsItsSigma) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> grain(0, 5);
  for (const double blur_px : {0.0, 0.7}) {
    double squares = 0;
    constexpr int kTrials = 200;
    for (int trial = 0; trial < kTrials; ++trial) {
      Image seen(41, 41);
      for (float& value : seen.values) value = grain(random);
      if (blur_px > 0) seen = GaussianBlur(seen, blur_px);
      const auto match = PrecisionOfMatch(seen, Spot(1), Vector2d::Zero());
      squares += std::pow(match->gain_over_sigma, 2);
    }
    EXPECT_NEAR(std::sqrt(squares / kTrials), 1.0, 0.15) << blur_px;
  }
}

TEST(PrecisionOfMatch, AFlatModelHasNone) {
  EXPECT_FALSE(PrecisionOfMatch(Spot(1), Image(41, 41, 3.0f), Vector2d::Zero()));
  EXPECT_FALSE(PrecisionOfMatch(Image(41, 41, kNoData), Spot(1), Vector2d::Zero()));
}

}  // namespace
}  // namespace orient::interior
