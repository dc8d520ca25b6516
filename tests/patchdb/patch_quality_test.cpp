#include "patchdb/patch_quality.h"

#include <gtest/gtest.h>

#include <random>

#include "core/imaging/resample.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

Image Noise(int size, double blur_px) {
  std::mt19937 random(TestSeed());
  std::uniform_real_distribution<float> grey(0, 255);
  Image image(size, size);
  for (float& value : image.values) value = grey(random);
  return blur_px > 0 ? GaussianBlur(image, blur_px) : image;
}

TEST(PatchQuality, ContrastIsTheStandardDeviation) {
  Image image(2, 2);
  image.values = {10, 20, kNoData, kNoData};
  EXPECT_NEAR(Contrast(image), 5, 1e-6);
  EXPECT_EQ(Contrast(Image(3, 3, kNoData)), 0);
}

TEST(PatchQuality, RandomTextureIsDistinct) {
  const auto distinctness = Distinctness(Noise(79, 2), 31);
  ASSERT_TRUE(distinctness);
  EXPECT_GT(*distinctness, 0.3);
}

TEST(PatchQuality, RepeatedTextureIsNot) {
  Image image = Noise(79, 2);
  for (int row = 0; row < 79; ++row)
    for (int col = 15; col < 79; ++col) image.At(col, row) = image.At(col - 15, row);
  EXPECT_LT(*Distinctness(image, 31), 0.1);
}

TEST(PatchQuality, FlatOrIncompleteMiddleHasNoDistinctness) {
  EXPECT_FALSE(Distinctness(Image(79, 79, 100), 31));
  Image image = Noise(79, 2);
  for (int row = 20; row < 60; ++row)
    for (int col = 20; col < 60; ++col) image.At(col, row) = kNoData;
  EXPECT_FALSE(Distinctness(image, 31));
}

TEST(PatchQuality, CoarseTextureSurvivesLongerThanFine) {
  EXPECT_EQ(Persistence(Noise(61, 3)), 3);
  Image lines(61, 61, 100);  // one pixel wide, weak
  std::mt19937 random(TestSeed());
  for (int i = 0; i < 6; ++i) {
    const int at = static_cast<int>(random() % 61);
    for (int k = 0; k < 61; ++k) lines.At(at, k) = lines.At(k, at) = 103;
  }
  EXPECT_LT(Persistence(lines), 3);
  EXPECT_EQ(Persistence(Image(61, 61, 100)), 0);
}

}  // namespace
}  // namespace orient
