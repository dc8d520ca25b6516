#include "core/matching/gradient_channels.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr int kSide = 41, kMargin = 12;

// Smooth random ground of two scales.
Image Ground(unsigned seed, int size) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Image ground(size, size);
  for (float& value : ground.values) value = 100 * normal(random);
  return GaussianBlur(ground, 1.8);
}

Image Part(const Image& image, const Eigen::Vector2d& corner, int side) {
  Image part(side, side);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col)
      part.At(col, row) = SampleBicubic(image, corner + Eigen::Vector2d(col + 0.5, row + 0.5));
  return part;
}

// Dark becomes bright and bright becomes dark in one half.
Image HalfInverted(Image image) {
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width / 2; ++col) image.At(col, row) = 50 - image.At(col, row);
  return image;
}

TEST(GradientChannels, DoNotKnowDarkFromBright) {
  const Image image = Ground(TestSeed(), 30);
  Image negative = image;
  for (float& value : negative.values) value = 200 - 3 * value;
  const GradientChannels a = ChannelsOf(image), b = ChannelsOf(negative);
  for (std::size_t k = 0; k < kGradientChannels; ++k)
    for (int row = 1; row < 29; ++row)
      for (int col = 1; col < 29; ++col)
        ASSERT_NEAR(a.channels[k].At(col, row), b.channels[k].At(col, row), 1e-3);
}

TEST(GradientChannels, CorrelateFullyWhereTheImageIsTheTemplate) {
  const Image image = Ground(TestSeed(), kSide + 2 * kMargin);
  const Image templ = Part(image, Eigen::Vector2d::Constant(kMargin), kSide);
  const auto peaks = FindPeaks(CorrelateChannels(ChannelsOf(templ), ChannelsOf(image)), 2, 2.5, -1);
  ASSERT_GE(peaks.size(), 2u);
  EXPECT_LT((peaks[0].position - Eigen::Vector2d::Constant(kMargin)).norm(), 0.1);
  EXPECT_GT(peaks[0].score, 0.95);
  EXPECT_LT(peaks[1].score, 0.4);
}

TEST(GradientChannels, FindThePlaceWhereHalfOfTheContrastIsInverted) {
  const Image image = Ground(TestSeed(), kSide + 2 * kMargin);
  const Image templ = HalfInverted(Part(image, Eigen::Vector2d::Constant(kMargin), kSide));
  const auto grey = FindPeaks(Correlate(templ, image), 1, 2.5, -1);
  const auto channels =
      FindPeaks(CorrelateChannels(ChannelsOf(templ), ChannelsOf(image)), 1, 2.5, -1);
  ASSERT_FALSE(grey.empty() || channels.empty());
  EXPECT_LT(grey[0].score, 0.6);
  EXPECT_GT(channels[0].score, 0.8);
  EXPECT_LT((channels[0].position - Eigen::Vector2d::Constant(kMargin)).norm(), 0.3);
}

TEST(GradientChannels, SpatialAndFftAgreeWhereDataIsMissing) {
  Image image = Ground(TestSeed(), 70);
  for (int row = 30; row < 45; ++row)
    for (int col = 20; col < 31; ++col) image.At(col, row) = kNoData;
  const GradientChannels channels = ChannelsOf(image);
  EXPECT_TRUE(std::isnan(channels.channels[0].At(25, 40)));
  const Image scores = CorrelateChannels(ChannelsOf(Part(image, {5, 5}, 21)), channels);
  EXPECT_GT(scores.At(5, 5), 0.9F);
  EXPECT_TRUE(std::isnan(scores.At(15, 27)));  // most of it has no data
}

TEST(GradientChannels, OfNothingMatchNothing) {
  const Image flat(30, 30, 7), image = Ground(TestSeed(), 40);
  const Image scores = CorrelateChannels(ChannelsOf(flat), ChannelsOf(image));
  for (const float score : scores.values) EXPECT_TRUE(std::isnan(score));
  EXPECT_TRUE(CorrelateChannels(ChannelsOf(image), ChannelsOf(flat)).Empty());
  EXPECT_FALSE(MatchChannels(ChannelsOf(flat), ChannelsOf(image), {5, 5}, 2));
}

// Independent noise on both sides, half of the contrast inverted: what least squares says of its
// precision must be true.
TEST(MatchChannels, IsAsPreciseAsItSays) {
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> noise(0, 4);
  std::uniform_real_distribution<double> offset(-0.5, 0.5);
  double squares = 0, errors = 0;
  int count = 0;
  for (int run = 0; run < 40; ++run) {
    Image image = Ground(TestSeed() + 17u * static_cast<unsigned>(run), kSide + 2 * kMargin);
    const Eigen::Vector2d truth(kMargin + offset(random), kMargin + offset(random));
    Image templ = HalfInverted(Part(image, truth, kSide));
    for (float& value : templ.values) value += noise(random);
    for (float& value : image.values) value += noise(random);
    const auto match =
        MatchChannels(ChannelsOf(templ), ChannelsOf(image), Eigen::Vector2d::Constant(kMargin), 2);
    ASSERT_TRUE(match);
    const Eigen::Vector2d error = match->corner - truth;
    squares += error.dot(match->covariance.inverse() * error);
    errors += error.squaredNorm();
    count += 2;
  }
  const double normalised = std::sqrt(squares / count);
  RecordProperty("normalised", std::to_string(normalised));
  std::printf("error %.3f px RMS a coordinate, normalised %.2f\n", std::sqrt(errors / count),
              normalised);
  EXPECT_LT(std::sqrt(errors / count), 0.1);
  EXPECT_GT(normalised, 0.7);
  EXPECT_LT(normalised, 1.4);
}

}  // namespace
}  // namespace orient
