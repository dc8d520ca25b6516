#include "patchdb/harvest/patch_quality.h"

#include <gtest/gtest.h>

#include <random>

#include "core/raster/resample.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
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
  const auto second = FindSecondPeak(Noise(79, 2), 31);
  ASSERT_TRUE(second);
  EXPECT_GT(second->Distinctness(), 0.3);
}

TEST(PatchQuality, RepeatedTextureIsNot) {
  Image image = Noise(79, 2);
  for (int row = 0; row < 79; ++row)
    for (int col = 15; col < 79; ++col) image.At(col, row) = image.At(col - 15, row);
  const auto second = FindSecondPeak(image, 31);
  ASSERT_TRUE(second);
  EXPECT_LT(second->Distinctness(), 0.1);
  EXPECT_NEAR(*second->distance_px, 15, 0.5);
}

TEST(PatchQuality, NoiseIsMeasuredOnSmoothGroundAndEdges) {
  Image image(79, 79);
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> noise(0, 5);
  for (int row = 0; row < 79; ++row)
    for (int col = 0; col < 79; ++col)
      image.At(col, row) = static_cast<float>(col + 2 * row + (col > 40 ? 80 : 0)) + noise(random);
  EXPECT_NEAR(NoiseOf(image), 5, 0.4);
  EXPECT_EQ(NoiseOf(Image(79, 79, kNoData)), 0);
}

TEST(PatchQuality, NoiseMakesRepeatedTextureNoMoreDistinct) {
  Image image(79, 79);
  std::mt19937 random(TestSeed());
  std::normal_distribution<float> noise(0, 4);
  for (int row = 0; row < 79; ++row)
    for (int col = 0; col < 79; ++col)
      image.At(col, row) = 100 + 10 * std::sin(static_cast<float>(col) * 0.6F) + noise(random);
  const auto second = FindSecondPeak(image, 31);
  ASSERT_TRUE(second);
  EXPECT_LT(second->Distinctness(), 0.1);
}

TEST(PatchQuality, FlatOrIncompleteMiddleHasNoDistinctness) {
  EXPECT_FALSE(FindSecondPeak(Image(79, 79, 100), 31));
  Image image = Noise(79, 2);
  for (int row = 20; row < 60; ++row)
    for (int col = 20; col < 60; ++col) image.At(col, row) = kNoData;
  EXPECT_FALSE(FindSecondPeak(image, 31));
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

TEST(PatchQuality, EnergyKnowsDirections) {
  Image rows(61, 61);  // bright to the north-east: east and north both gain
  for (int row = 0; row < 61; ++row)
    for (int col = 0; col < 61; ++col) rows.At(col, row) = static_cast<float>(2 * col - 3 * row);
  const Eigen::Vector3d energy = TextureEnergy(rows);
  EXPECT_NEAR(energy[0], 4, 1e-3);
  EXPECT_NEAR(energy[1], 6, 1e-3);
  EXPECT_NEAR(energy[2], 9, 1e-3);
  EXPECT_EQ(TextureEnergy(Image(61, 61, kNoData)).norm(), 0);
}

TEST(PatchQuality, QualityIsTheWorstMark) {
  Patch patch;
  EXPECT_FALSE(QualityOf(patch));
  patch.distinctness = 0.6;
  patch.persistence = 3;
  patch.energy = Eigen::Vector3d(100, 0, 90);
  patch.relief_px = 0;
  EXPECT_NEAR(*QualityOf(patch), 1, 1e-9);
  const auto with = [&](auto change) {
    Patch other = patch;
    change(other);
    return *QualityOf(other);
  };
  EXPECT_LT(with([](Patch& p) { p.distinctness = 0.21; }), kGoodQuality);
  EXPECT_LT(with([](Patch& p) { p.persistence = 1; }), kGoodQuality);
  EXPECT_LT(with([](Patch& p) { p.energy = Eigen::Vector3d(100, 99, 100); }), kGoodQuality);
  EXPECT_LT(with([](Patch& p) { p.relief_px = 70; }), kGoodQuality);
  EXPECT_LT(with([](Patch& p) { p.lean_px = 5; }), kGoodQuality);
  EXPECT_LT(with([](Patch& p) {
              p.evidence.push_back({1, Eigen::Vector2d(5, 5), Eigen::Vector2d(0.9, 0.9)});
            }),
            kGoodQuality);
}

}  // namespace
}  // namespace orient::patchdb
