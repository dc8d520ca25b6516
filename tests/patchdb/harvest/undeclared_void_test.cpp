#include "patchdb/harvest/undeclared_void.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace orient::patchdb {
namespace {

constexpr int kSide = 200;

// Grey values from 40 to 210, as of fields and roads.
Image Ground() {
  Image grey(kSide, kSide);
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col)
      grey.At(col, row) = static_cast<float>(
          std::round(125 + 60 * std::sin(col * 0.3) * std::cos(row * 0.2) + 25 * std::sin(row)));
  return grey;
}

// What `paint(col, row, value)` makes of the ground.
template <typename Paint>
Image Painted(const Paint& paint) {
  Image grey = Ground();
  for (int row = 0; row < kSide; ++row)
    for (int col = 0; col < kSide; ++col) grey.At(col, row) = paint(col, row, grey.At(col, row));
  return grey;
}

double FromMiddle(int col, int row) { return std::hypot(col - 100, row - 100); }

int CountOf(const Image& grey, int bits = 8) {
  const auto voids = UndeclaredVoids(grey, bits);
  return static_cast<int>(std::count(voids.begin(), voids.end(), std::uint8_t{1}));
}

TEST(UndeclaredVoid, AHoleOfBlackOrWhiteIsOneToItsLastPixel) {
  for (const int bits : {8, 11, 16}) {
    for (const float end : {0.0f, static_cast<float>((1 << bits) - 1)}) {
      const Image grey = Painted(
          [&](int col, int row, float value) { return FromMiddle(col, row) < 32 ? end : value; });
      const auto voids = UndeclaredVoids(grey, bits);
      for (int row = 0; row < kSide; ++row)
        for (int col = 0; col < kSide; ++col)
          ASSERT_EQ(
              voids[static_cast<std::size_t>(row) * kSide + static_cast<std::size_t>(col)] != 0,
              FromMiddle(col, row) < 32)
              << bits << " bits, " << end << ": " << col << " " << row;
    }
  }
}

TEST(UndeclaredVoid, AnyOtherValueIsNone) {
  EXPECT_EQ(CountOf(Painted([](int col, int, float value) { return col < 90 ? 128 : value; })), 0);
}

TEST(UndeclaredVoid, SinglePixelsSmallSpotsAndThinLinesAreNone) {
  std::mt19937 random(1);
  EXPECT_EQ(CountOf(Painted([&](int, int, float value) {
              const auto dice = random() % 20;
              return dice == 0 ? 0 : dice == 1 ? 255 : value;
            })),
            0);
  EXPECT_EQ(CountOf(Painted([](int col, int row, float value) {
              return col % 40 < 20 && row % 40 < 20 ? 255 : value;
            })),
            0)
      << "cars, roofs of huts";
  EXPECT_EQ(CountOf(Painted([](int col, int, float value) { return col % 50 < 6 ? 255 : value; })),
            0);
}

// A bright roof of 60 x 60 px under a lens that blurs its edges over two pixels.
TEST(UndeclaredVoid, ASaturatedRoofIsNone) {
  const Image grey = Painted([](int col, int row, float value) {
    const double inside =
        30 - std::max(std::abs(col - 100), std::abs(row - 100));  // px within its edge
    const double share = 0.5 * (1 + std::erf(inside / 1.4));
    return static_cast<float>(std::min(255.0, std::round(share * 330 + (1 - share) * value)));
  });
  ASSERT_EQ(grey.At(100, 100), 255);
  EXPECT_EQ(CountOf(grey), 0);
}

TEST(UndeclaredVoid, DarkWaterWithNoiseIsNoneHoweverLarge) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(1, 1.5);
  EXPECT_EQ(CountOf(Painted([&](int col, int, float value) {
              return col < 120 ? static_cast<float>(std::max(0.0, std::round(noise(random))))
                               : value;
            })),
            0);
}

// Compression leaves ripples of a few grey values along its border.
TEST(UndeclaredVoid, TheRippledBorderOfACompressedVoidBelongsToIt) {
  const Image grey = Painted([](int col, int row, float value) {
    if (col >= 100) return value;
    return col < 92 ? 1.0f : static_cast<float>((col * 7 + row * 3) % 8);
  });
  EXPECT_EQ(CountOf(grey), 100 * kSide);
}

// As a raster's margin is: beyond a raster there is no data either.
TEST(UndeclaredVoid, ABlackRimOfDeclaredNodataIsOneThoughNarrow) {
  const Image grey = Painted([](int col, int, float value) {
    return col < 100 ? kNoData : col < 102 ? 0.0f : value;
  });
  EXPECT_EQ(CountOf(grey), 2 * kSide);
  EXPECT_EQ(CountOf(Painted([](int col, int row, float value) {
              return col < 100 ? kNoData : col < 102 && row % 20 < 9 ? 0.0f : value;
            })),
            0)
      << "shadows that happen to lie there";
}

TEST(UndeclaredVoid, NearlyAllImagesAreDoneWithTheShareNearTheEnds) {
  EXPECT_EQ(ShareNearEnds(Ground(), 8), 0);
  EXPECT_NEAR(ShareNearEnds(Painted([](int col, int, float v) { return col < 50 ? 255 : v; }), 8),
              0.25, 1e-9);
  EXPECT_EQ(ShareNearEnds(Image(), 8), 0);
}

}  // namespace
}  // namespace orient::patchdb
