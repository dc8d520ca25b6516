#include "core/raster/resample.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <stdexcept>

#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr double kFloatRounding = 4e-5;  // grey values up to 200 as float, summed up

double Ramp(const Eigen::Vector2d& p) { return 100 + 1.25 * p.x() - 0.75 * p.y(); }

Image RampImage(int width = 30, int height = 20) { return Draw(width, height, Ramp); }

TEST(MiddleOf, KeepsTheMiddlePixel) {
  const Image middle = MiddleOf(RampImage(31, 21), 5, 3);
  EXPECT_EQ(middle.width, 5);
  EXPECT_EQ(middle.height, 3);
  EXPECT_EQ(middle.At(2, 1), RampImage(31, 21).At(15, 10));
  EXPECT_EQ(MiddleOf(RampImage(), 30, 20).values, RampImage().values);
}

TEST(Mirrored, ColumnsCountFromTheOtherSideAndRowsStay) {
  const Image image = RampImage(31, 21), mirrored = Mirrored(image);
  EXPECT_EQ(mirrored.At(0, 4), image.At(30, 4));
  EXPECT_EQ(mirrored.At(15, 20), image.At(15, 20));
  EXPECT_EQ(Mirrored(mirrored).values, image.values);
}

TEST(Sample, RampIsExactInTheCornerConvention) {
  const Image image = RampImage();
  for (const Eigen::Vector2d& p : {Eigen::Vector2d(0.5, 0.5), Eigen::Vector2d(29.5, 19.5),
                                   Eigen::Vector2d(7.3, 11.9), Eigen::Vector2d(1.2, 18.7)}) {
    EXPECT_NEAR(SampleBilinear(image, p), Ramp(p), kFloatRounding);
    EXPECT_NEAR(SampleBicubic(image, p), Ramp(p), kFloatRounding);
    float value = 0;
    Eigen::Vector2f gradient;
    ASSERT_TRUE(SampleBicubicWithGradient(image, p, &value, &gradient));
    EXPECT_NEAR(value, Ramp(p), kFloatRounding);
    EXPECT_NEAR(gradient.x(), 1.25, kFloatRounding);
    EXPECT_NEAR(gradient.y(), -0.75, kFloatRounding);
  }
}

RC_GTEST_PROP(Sample, PixelCentresGiveThePixels, ()) {
  const int c = *rc::gen::inRange(0, 12), r = *rc::gen::inRange(0, 9);
  const Texture texture(7);
  const Image image = Draw(12, 9, [&](const auto& p) { return texture.At(p); });
  RC_ASSERT(SampleBilinear(image, {c + 0.5, r + 0.5}) == image.At(c, r));
  RC_ASSERT(SampleBicubic(image, {c + 0.5, r + 0.5}) == image.At(c, r));
}

TEST(Sample, WithinHalfAPixelOfTheBorderIsNan) {
  const Image image = RampImage();
  for (const Eigen::Vector2d& p :
       {Eigen::Vector2d(0.49, 5), Eigen::Vector2d(5, 0.49), Eigen::Vector2d(29.51, 5),
        Eigen::Vector2d(5, 19.51), Eigen::Vector2d(-3, 5), Eigen::Vector2d(5, 1e9)}) {
    EXPECT_TRUE(std::isnan(SampleBilinear(image, p)));
    EXPECT_TRUE(std::isnan(SampleBicubic(image, p)));
  }
  EXPECT_TRUE(std::isnan(SampleBilinear(image, {kNoData, 5})));
  EXPECT_TRUE(std::isnan(SampleBilinear(Image(), {0, 0})));
}

TEST(Sample, SinglePixelImageHasOneValue) {
  EXPECT_EQ(SampleBicubic(Image(1, 1, 5), {0.5, 0.5}), 5);
  EXPECT_TRUE(std::isnan(SampleBicubic(Image(1, 1, 5), {0.6, 0.5})));
}

TEST(Sample, NanReachesAsFarAsTheKernelAndNoFarther) {
  Image image = RampImage();
  image.At(10, 10) = kNoData;
  EXPECT_TRUE(std::isnan(SampleBilinear(image, {10.1, 10.1})));
  EXPECT_TRUE(std::isnan(SampleBilinear(image, {9.6, 9.6})));
  EXPECT_FALSE(std::isnan(SampleBilinear(image, {9.5, 9.6})));  // its weight is zero
  EXPECT_TRUE(std::isnan(SampleBicubic(image, {8.6, 10.5})));
  EXPECT_FALSE(std::isnan(SampleBicubic(image, {8.4, 10.5})));
}

TEST(Sample, BicubicGradientIsTheSurfacesSlope) {
  const Texture texture(3, 6);
  const Image image = Draw(30, 30, [&](const auto& p) { return texture.At(p); });
  const Eigen::Vector2d p(12.34, 15.61);
  constexpr double kStep = 1e-3;
  float value = 0;
  Eigen::Vector2f gradient;
  ASSERT_TRUE(SampleBicubicWithGradient(image, p, &value, &gradient));
  for (int axis = 0; axis < 2; ++axis) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(axis);
    const double slope =
        (double(SampleBicubic(image, p + step)) - double(SampleBicubic(image, p - step))) /
        (2 * kStep);
    EXPECT_NEAR(gradient[axis], slope, 0.02);  // float values: 1e-5 / 1e-3
  }
}

// Compares away from the border, where a blur has one-sided neighbours.
void ExpectRampInside(const Image& image, double scale, int margin, double tolerance) {
  ASSERT_GT(image.width, 2 * margin);
  for (int r = margin; r < image.height - margin; ++r)
    for (int c = margin; c < image.width - margin; ++c)
      ASSERT_NEAR(image.At(c, r), Ramp(scale * Eigen::Vector2d(c + 0.5, r + 0.5)), tolerance);
}

TEST(Reduce, RampStaysTheRamp) {
  const Image image = RampImage(84, 63);
  ExpectRampInside(GaussianBlur(image, 1.3), 1, 6, kFloatRounding);
  ExpectRampInside(ReduceByTwo(image), 2, 1, kFloatRounding);
  const auto pyramid = BuildPyramid(image, 4);
  ASSERT_EQ(pyramid.size(), 4u);
  ExpectRampInside(pyramid[3], 8, 2, kFloatRounding);
  for (const double factor : {1.0, 2.0, 3.5, 1.3, 2.999})
    ExpectRampInside(ReduceBy(image, factor), factor, 1, kFloatRounding);
}

TEST(Reduce, SizesAreRoundedUp) {
  EXPECT_EQ(ReduceByTwo(Image(7, 4)).width, 4);
  EXPECT_EQ(ReduceByTwo(Image(7, 4)).height, 2);
  EXPECT_EQ(ReduceBy(Image(7, 4), 3.5).width, 2);
  EXPECT_EQ(ReduceBy(Image(7, 4), 3).width, 3);
  EXPECT_EQ(ReduceBy(Image(1, 1), 5).width, 1);
  EXPECT_TRUE(ReduceByTwo(Image()).Empty());
}

TEST(Reduce, ConstantStaysConstantUpToTheBorder) {
  for (const Image& image : {GaussianBlur(Image(9, 7, 3.5f), 2), ReduceByTwo(Image(9, 7, 3.5f)),
                             ReduceBy(Image(9, 7, 3.5f), 2.3)})
    for (const float value : image.values) EXPECT_NEAR(value, 3.5, 1e-6);
}

TEST(Reduce, NanStaysWhereItIs) {
  Image image(16, 16, 8);
  for (int r = 0; r < 16; ++r)
    for (int c = 0; c < 5; ++c) image.At(c, r) = kNoData;
  const Image blurred = GaussianBlur(image, 1);
  EXPECT_TRUE(std::isnan(blurred.At(4, 8)));
  EXPECT_NEAR(blurred.At(5, 8), 8, 1e-6);
  const Image half = ReduceByTwo(image);  // column 2 covers 4 and 5: half of it
  EXPECT_TRUE(std::isnan(half.At(1, 4)));
  EXPECT_TRUE(std::isnan(half.At(2, 4)));
  EXPECT_NEAR(half.At(3, 4), 8, 1e-6);
  EXPECT_TRUE(std::isnan(ReduceBy(image, 2).At(2, 4)));
  EXPECT_TRUE(std::isnan(ReduceBy(image, 3).At(1, 4)));  // columns 3 to 5: one of three
  EXPECT_NEAR(ReduceBy(image, 3.5).At(1, 2), 8, 1e-6);   // 3.5 to 7: more than half
}

TEST(Reduce, FinestDetailIsNotAliased) {
  // The finest chequerboard and a wave a little coarser than the new Nyquist limit.
  const Image chequers = Draw(32, 32, [](const auto& p) {
    return (static_cast<int>(p.x()) + static_cast<int>(p.y())) % 2 ? 1.0 : -1.0;
  });
  for (const float value : ReduceByTwo(chequers).values) EXPECT_NEAR(value, 0, 0.3);
  const Image wave =
      Draw(64, 8, [](const auto& p) { return std::cos(2 * std::numbers::pi * p.x() / 2.5); });
  const Image half = ReduceByTwo(wave);
  for (int c = 2; c < 30; ++c) EXPECT_LT(std::abs(half.At(c, 2)), 0.15);
}

TEST(Enlarge, KeepsPlacesAndValues) {
  const Image ramp = Draw(16, 12, [](const auto& p) { return 3 * p.x() - 2 * p.y(); });
  const Image large = EnlargeBy(ramp, 3);
  ASSERT_EQ(large.width, 48);
  ASSERT_EQ(large.height, 36);
  for (int row = 9; row < 27; ++row)
    for (int col = 9; col < 39; ++col)
      EXPECT_NEAR(large.At(col, row), 3 * (col + 0.5) / 3 - 2 * (row + 0.5) / 3, 0.2);
  EXPECT_EQ(EnlargeBy(ramp, 1).values, ramp.values);
}

TEST(Reduce, BrokenPromisesAreRefused) {
  EXPECT_THROW(EnlargeBy(Image(4, 4), 0), std::invalid_argument);
  EXPECT_THROW(ReduceBy(Image(4, 4), 0.5), std::invalid_argument);
  EXPECT_THROW(BuildPyramid(Image(4, 4), 0), std::invalid_argument);
  EXPECT_THROW(GaussianBlur(Image(4, 4), -1), std::invalid_argument);
}

}  // namespace
}  // namespace orient
