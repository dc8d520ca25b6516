#include "core/matching/correlation.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <random>
#include <stdexcept>

#include "tests/support/shared_data.h"
#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr double kSameByBothWays = 1e-4;  // the header's promise

Image TextureImage(int width, int height, unsigned seed = 5) {
  const Texture texture(seed);
  return Draw(width, height, [&](const auto& p) { return texture.At(p); });
}

// The definition, pixel by pixel.
double ByDefinition(const Image& t, const Image& image, int col, int row) {
  std::vector<double> a, b;
  for (int r = 0; r < t.height; ++r)
    for (int c = 0; c < t.width; ++c) {
      if (std::isnan(t.At(c, r)) || std::isnan(image.At(col + c, row + r))) continue;
      a.push_back(double(t.At(c, r)));
      b.push_back(double(image.At(col + c, row + r)));
    }
  const auto n = static_cast<double>(a.size());
  double ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
  for (size_t k = 0; k < a.size(); ++k) ma += a[k] / n, mb += b[k] / n;
  for (size_t k = 0; k < a.size(); ++k) {
    aa += (a[k] - ma) * (a[k] - ma);
    bb += (b[k] - mb) * (b[k] - mb);
    ab += (a[k] - ma) * (b[k] - mb);
  }
  return ab / std::sqrt(aa * bb);
}

void ExpectSame(const Image& a, const Image& b) {
  ASSERT_EQ(a.values.size(), b.values.size());
  for (size_t k = 0; k < a.values.size(); ++k) {
    ASSERT_EQ(std::isnan(a.values[k]), std::isnan(b.values[k])) << k;
    if (std::isnan(a.values[k])) continue;
    ASSERT_NEAR(a.values[k], b.values[k], kSameByBothWays) << k;
  }
}

TEST(Correlate, CutTemplateIsFoundWhereItWasCut) {
  const Image image = TextureImage(70, 50);
  const Image templ = Crop(image, 21, 13, 15, 11);
  const Image scores = Correlate(templ, image);
  EXPECT_EQ(scores.width, 56);
  EXPECT_EQ(scores.height, 40);
  EXPECT_NEAR(scores.At(21, 13), 1, 1e-6);
  const auto peaks = FindPeaks(scores, 1, 3, 0.5);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_NEAR(peaks[0].position.x(), 21, 0.05);
  EXPECT_NEAR(peaks[0].position.y(), 13, 0.05);
}

TEST(Correlate, MaskedOnBothSidesFollowsTheDefinition) {
  Image image = TextureImage(60, 45);
  Image templ = Crop(TextureImage(60, 45, 6), 10, 10, 16, 12);
  std::mt19937 random(TestSeed());
  for (float& value : image.values)
    if (random() % 20 == 0) value = kNoData;
  for (int c = 0; c < 6; ++c)
    for (int r = 0; r < 5; ++r) templ.At(c, r) = kNoData;
  const Image spatial = CorrelateSpatial(templ, image);
  for (int r = 0; r < spatial.height; r += 5)
    for (int c = 0; c < spatial.width; c += 5)
      EXPECT_NEAR(spatial.At(c, r), ByDefinition(templ, image, c, r), 1e-5);
  ExpectSame(spatial, CorrelateFft(templ, image));
}

TEST(Correlate, EachMaskAloneAndNoMaskAgreeByBothWays) {
  const Image image = TextureImage(64, 53);
  Image holes = image;
  for (int c = 20; c < 40; ++c) holes.At(c, 30) = kNoData;
  Image templ = Crop(image, 21, 13, 15, 11);
  ExpectSame(CorrelateSpatial(templ, image), CorrelateFft(templ, image));
  ExpectSame(CorrelateSpatial(templ, holes), CorrelateFft(templ, holes));
  templ.At(0, 0) = kNoData;
  ExpectSame(CorrelateSpatial(templ, image), CorrelateFft(templ, image));
}

TEST(Correlate, HugeOffsetAndSteepContrastStayExact) {
  // 16 bit with a bright half: the dark half's small contrast must not drown in rounding.
  Image image = TextureImage(90, 60);
  for (int r = 0; r < image.height; ++r)
    for (int c = 0; c < image.width; ++c)
      image.At(c, r) = c < 45 ? 1000 + image.At(c, r) * 0.1f : 60000 + 30 * image.At(c, r);
  const Image templ = Crop(image, 10, 13, 15, 11);
  const Image fft = CorrelateFft(templ, image), spatial = CorrelateSpatial(templ, image);
  ExpectSame(spatial, fft);
  EXPECT_NEAR(fft.At(10, 13), 1, 1e-5);
  EXPECT_NEAR(fft.At(25, 20), ByDefinition(templ, image, 25, 20), 1e-4);
}

RC_GTEST_PROP(Correlate, GainAndOffsetDoNotMatter, ()) {
  const int gain = *rc::gen::inRange(1, 50), offset = *rc::gen::inRange(-500, 500);
  Image image = TextureImage(30, 30);
  const Image templ = Crop(TextureImage(30, 30, 8), 3, 3, 9, 9);
  const Image before = Correlate(templ, image);
  for (float& value : image.values)
    value = -static_cast<float>(gain) * value + static_cast<float>(offset);
  const Image after = Correlate(templ, image);
  for (size_t k = 0; k < before.values.size(); ++k)
    RC_ASSERT(std::abs(before.values[k] + after.values[k]) < 1e-4f);
}

TEST(Correlate, FlatTemplateOrFlatImagePartGivesNan) {
  Image image = TextureImage(40, 40);
  for (int r = 0; r < 20; ++r)
    for (int c = 0; c < 20; ++c) image.At(c, r) = 77.7f;
  const Image templ = Crop(image, 25, 25, 9, 9);
  for (const Image& scores : {CorrelateSpatial(templ, image), CorrelateFft(templ, image)}) {
    EXPECT_TRUE(std::isnan(scores.At(3, 3)));
    EXPECT_FALSE(std::isnan(scores.At(15, 15)));
  }
  for (const float score : Correlate(Image(5, 5, 9), image).values) EXPECT_TRUE(std::isnan(score));
  for (const float score : Correlate(Image(5, 5, kNoData), image).values)
    EXPECT_TRUE(std::isnan(score));
  for (const float score : Correlate(templ, Image(20, 20, kNoData)).values)
    EXPECT_TRUE(std::isnan(score));
}

TEST(Correlate, TooFewValidPixelsGiveNan) {
  Image image = TextureImage(40, 40);
  for (int r = 0; r < 40; ++r)
    for (int c = 0; c < 20; ++c) image.At(c, r) = kNoData;
  const Image templ = Crop(image, 22, 22, 10, 10);
  for (const Image& scores : {CorrelateSpatial(templ, image), CorrelateFft(templ, image)}) {
    EXPECT_TRUE(std::isnan(scores.At(17, 5)));   // 7 of 10 columns
    EXPECT_FALSE(std::isnan(scores.At(18, 5)));  // 8 of 10
  }
  EXPECT_FALSE(std::isnan(Correlate(templ, image, 0.5).At(15, 5)));
}

TEST(Correlate, TemplateLargerThanTheImageGivesAnEmptyResult) {
  EXPECT_TRUE(Correlate(TextureImage(9, 5), TextureImage(8, 20)).Empty());
  EXPECT_TRUE(Correlate(Image(), TextureImage(8, 20)).Empty());
}

TEST(CorrelationCoefficient, OneForItselfAndNanForFlat) {
  const Image image = TextureImage(20, 20);
  EXPECT_NEAR(CorrelationCoefficient(image, image), 1, 1e-6);
  EXPECT_TRUE(std::isnan(CorrelationCoefficient(image, Image(20, 20, 4))));
  Image holes = image;
  for (size_t k = 0; k < 150; ++k) holes.values[k] = kNoData;
  EXPECT_TRUE(std::isnan(CorrelationCoefficient(image, holes)));
  EXPECT_NEAR(CorrelationCoefficient(image, holes, 0.5), 1, 1e-6);
  EXPECT_THROW(CorrelationCoefficient(image, Image(3, 3)), std::invalid_argument);
}

Image Bump(int width, int height, const Eigen::Vector2d& cell, double top) {
  Image scores(width, height);
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c)
      scores.At(c, r) =
          static_cast<float>(top - 0.01 * (Eigen::Vector2d(c, r) - cell).squaredNorm());
  return scores;
}

TEST(FindPeaks, ParabolaGivesTheVertex) {
  const auto peaks = FindPeaks(Bump(20, 15, {7.3, 8.8}, 0.9), 5, 2, 0);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_NEAR(peaks[0].position.x(), 7.3, 1e-4);
  EXPECT_NEAR(peaks[0].position.y(), 8.8, 1e-4);
}

TEST(FindPeaks, PlateauIsOnePeakInItsMiddle) {
  Image scores(12, 9, 0.1f);
  for (int c = 4; c <= 6; ++c) scores.At(c, 3) = scores.At(c, 4) = 0.8f;
  const auto peaks = FindPeaks(scores, 10, 1, 0.5);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_EQ(peaks[0].position, Eigen::Vector2d(5, 3.5));
}

TEST(FindPeaks, ShoulderOfAHigherPeakIsNoPeak) {
  Image scores(12, 9, 0.1f);
  for (int c = 2; c <= 8; ++c) scores.At(c, 4) = 0.8f;
  scores.At(9, 4) = 0.9f;
  const auto peaks = FindPeaks(scores, 10, 1, 0.5);
  ASSERT_EQ(peaks.size(), 1u);
  EXPECT_NEAR(peaks[0].position.x(), 9, 0.5);
}

TEST(FindPeaks, BestFirstApartAndAboveTheLimit) {
  Image scores(30, 10, 0);
  scores.At(5, 5) = 0.7f;
  scores.At(8, 5) = 0.9f;
  scores.At(20, 5) = 0.8f;
  scores.At(27, 5) = 0.3f;
  auto peaks = FindPeaks(scores, 10, 4, 0.5);
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_FLOAT_EQ(static_cast<float>(peaks[0].score), 0.9f);
  EXPECT_FLOAT_EQ(static_cast<float>(peaks[1].score), 0.8f);
  EXPECT_EQ(FindPeaks(scores, 10, 2, 0.5).size(), 3u);
  EXPECT_EQ(FindPeaks(scores, 1, 2, 0.5).size(), 1u);
  EXPECT_TRUE(FindPeaks(scores, 0, 2, 0.5).empty());
}

TEST(FindPeaks, NanAndBorderDoNotStopAPeak) {
  Image scores(9, 9, kNoData);
  scores.At(0, 4) = 0.9f;
  scores.At(5, 5) = 0.8f;
  scores.At(5, 6) = 0.7f;
  const auto peaks = FindPeaks(scores, 10, 1, 0.5);
  ASSERT_EQ(peaks.size(), 2u);
  EXPECT_EQ(peaks[0].position, Eigen::Vector2d(0, 4));
  EXPECT_EQ(peaks[1].position, Eigen::Vector2d(5, 5));
  EXPECT_TRUE(FindPeaks(Image(9, 9, kNoData), 3, 1, -1).empty());
  EXPECT_TRUE(FindPeaks(Image(), 3, 1, -1).empty());
}

}  // namespace
}  // namespace orient
