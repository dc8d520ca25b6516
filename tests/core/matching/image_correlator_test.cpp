#include "core/matching/image_correlator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/matching/correlation.h"
#include "tests/support/shared_data.h"
#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr int kSide = 15;

Image TextureImage(int width, int height, double col = 0, double row = 0) {
  const Texture texture(11);
  return Draw(width, height,
              [&](const auto& p) { return texture.At(p + Eigen::Vector2d(col, row)); });
}

Peak Best(const Image& scores) { return FindPeaks(scores, 1, 2, 0.1).at(0); }

TEST(ImageCorrelator, GivesTheCoefficientsOfCorrelation) {
  const Image image = TextureImage(90, 61), templ = TextureImage(kSide, kSide, 31, 17);
  const Image scores = ImageCorrelator(image, kSide).Scores(templ);
  const Image expected = CorrelateSpatial(templ, image);
  ASSERT_EQ(scores.width, expected.width);
  ASSERT_EQ(scores.height, expected.height);
  for (std::size_t i = 0; i < scores.values.size(); ++i)
    EXPECT_NEAR(scores.values[i], expected.values[i], 2e-3) << i;
}

TEST(ImageCorrelator, FindsSeveralTemplatesOneAfterTheOther) {
  const ImageCorrelator search(TextureImage(90, 61), kSide);
  for (const auto& [col, row] : {std::pair(31, 17), std::pair(2, 40), std::pair(70, 3)}) {
    const Peak peak = Best(search.Scores(TextureImage(kSide, kSide, col, row)));
    EXPECT_NEAR(peak.position.x(), col, 0.1);
    EXPECT_NEAR(peak.position.y(), row, 0.1);
    EXPECT_GT(peak.score, 0.99);
  }
}

TEST(ImageCorrelator, FindsATemplateWithAGap) {
  Image templ = TextureImage(kSide, kSide, 31, 17);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < 5; ++col) templ.At(col, row) = kNoData;
  const Peak peak = Best(ImageCorrelator(TextureImage(90, 61), kSide).Scores(templ));
  EXPECT_NEAR(peak.position.x(), 31, 0.5);
  EXPECT_NEAR(peak.position.y(), 17, 0.5);
  EXPECT_GT(peak.score, 0.8);
}

TEST(ImageCorrelator, HasNoCoefficientWhereTheImageIsFlatOrMissing) {
  Image image = TextureImage(90, 61);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < 40; ++col) image.At(col, row) = col < 20 ? kNoData : 7.0F;
  const Image scores = ImageCorrelator(image, kSide).Scores(TextureImage(kSide, kSide, 60, 20));
  EXPECT_TRUE(std::isnan(scores.At(2, 20)));
  EXPECT_TRUE(std::isnan(scores.At(23, 20)));
  EXPECT_NEAR(Best(scores).position.x(), 60, 0.1);
}

TEST(ImageCorrelator, RefusesTemplatesOfAnotherSize) {
  const Image image = TextureImage(30, 20);
  EXPECT_THROW(ImageCorrelator(image, 21), std::invalid_argument);
  EXPECT_THROW(ImageCorrelator(image, kSide).Scores(Image(12, 12)), std::invalid_argument);
}

}  // namespace
}  // namespace orient
