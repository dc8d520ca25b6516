#include "core/raster/spline_image.h"

#include <gtest/gtest.h>

#include <random>

namespace orient {
namespace {

Image Noise(int width, int height) {
  std::mt19937 random(7);
  std::normal_distribution<float> grey(100, 20);
  Image image(width, height);
  for (float& value : image.values) value = grey(random);
  return image;
}

// All that a grid says must be what single places say.
void ExpectAsSingly(const SplineImage& spline, const Eigen::Vector2d& first, int cols, int rows) {
  const SplineSamples samples = spline.SampleGrid(first, cols, rows);
  ASSERT_EQ(samples.known.size(), cols * rows);
  for (int i = 0; i < cols * rows; ++i) {
    double value = 0;
    Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
    const Eigen::Vector2d place = first + Eigen::Vector2d(i % cols, i / cols);
    const bool known = spline.Sample(place, &value, &gradient);
    ASSERT_EQ(samples.known[i] == 1, known) << place.transpose();
    if (!known) value = 0;
    EXPECT_NEAR(samples.value[i], value, 1e-11);
    EXPECT_NEAR(samples.by_col[i], gradient.x(), 1e-11);
    EXPECT_NEAR(samples.by_row[i], gradient.y(), 1e-11);
  }
}

TEST(SplineImage, GoesThroughItsPixels) {
  const Image image = Noise(20, 15);
  const SplineSamples samples = SplineImage(image, {0, 0, 20, 15}).SampleGrid({0.5, 0.5}, 20, 15);
  for (int i = 0; i < 20 * 15; ++i)
    EXPECT_NEAR(samples.value[i], image.values[static_cast<std::size_t>(i)], 1e-9);
}

TEST(SplineImage, AGridIsSampledAsItsPlacesAre) {
  const SplineImage spline(Noise(40, 30), {5, 3, 30, 24});
  ExpectAsSingly(spline, {10.2, 7.9}, 12, 9);
  ExpectAsSingly(spline, {10.5, 7.5}, 25, 20);
  ExpectAsSingly(spline, {-3.3, -2.8}, 60, 50);  // beyond all borders
}

TEST(SplineImage, WhatIsNoDataIsNotKnownNorIsWhatIsBesideIt) {
  Image image = Noise(40, 30);
  image.At(14, 12) = kNoData;
  ExpectAsSingly(SplineImage(image, {0, 0, 40, 30}), {5.3, 4.1}, 22, 18);
}

TEST(SplineImage, OfAPixelOrTwoAndOfNothing) {
  for (int size = 1; size <= 3; ++size) {
    const SplineImage spline(Noise(size, size), {0, 0, size, size});
    ExpectAsSingly(spline, {0.5, 0.5}, size, size);
    ExpectAsSingly(spline, {0.2, 0.9}, 4, 4);
  }
  const SplineImage nothing(Noise(5, 5), {9, 9, 4, 4});
  EXPECT_EQ(nothing.SampleGrid({9.5, 9.5}, 3, 3).known.sum(), 0);
  const SplineImage spline(Noise(5, 5), {0, 0, 5, 5});
  EXPECT_EQ(spline.SampleGrid({std::nan(""), 1e300}, 3, 3).known.sum(), 0);
}

}  // namespace
}  // namespace orient
