#include "core/matching/spot_correlation.h"

#include <gtest/gtest.h>

#include "core/matching/correlation.h"
#include "tests/support/texture.h"

namespace orient {
namespace {

constexpr double kMinValid = 0.7;

Image TextureImage(int width, int height, unsigned seed) {
  const Texture texture(seed);
  return Draw(width, height, [&](const auto& p) { return texture.At(p); });
}

// A disc: rows of different lengths, none of them as long as the template is wide.
Image Disc(const Image& image) {
  Image disc = image;
  for (int row = 0; row < disc.height; ++row)
    for (int col = 0; col < disc.width; ++col)
      if (std::hypot(col - 0.5 * (disc.width - 1), row - 0.5 * (disc.height - 1)) >
          0.45 * disc.width)
        disc.At(col, row) = kNoData;
  return disc;
}

void ExpectLikeCorrelate(const Image& templ, const Image& image) {
  const Image everywhere = CorrelateFft(templ, image, kMinValid);
  const SpotTemplate spot(templ);
  const SpotImage places(image);
  for (int row = 0; row < everywhere.height; ++row)
    for (int col = 0; col < everywhere.width; ++col) {
      const double here = places.Correlate(spot, col, row, kMinValid);
      ASSERT_EQ(std::isnan(here), std::isnan(everywhere.At(col, row))) << col << " " << row;
      if (std::isnan(here)) continue;
      ASSERT_NEAR(here, everywhere.At(col, row), 1e-4) << col << " " << row;
    }
}

TEST(SpotImage, SaysWhatCorrelatingEverywhereSays) {
  ExpectLikeCorrelate(Disc(TextureImage(19, 19, 3)), TextureImage(60, 45, 4));
  ExpectLikeCorrelate(TextureImage(33, 12, 5), TextureImage(60, 45, 6));
}

TEST(SpotImage, LeavesOutWhatHasNoData) {
  Image image = TextureImage(60, 45, 7);
  for (int row = 0; row < 14; ++row)
    for (int col = 0; col < 60; ++col) image.At(col, row) = kNoData;
  image.At(40, 30) = kNoData;
  ExpectLikeCorrelate(Disc(TextureImage(19, 19, 8)), image);
}

TEST(SpotImage, IsNanOutsideAndWhereItIsFlat) {
  const SpotTemplate spot(TextureImage(9, 9, 1));
  const Image flat(20, 20, 7);
  const SpotImage places(flat);
  EXPECT_TRUE(std::isnan(places.Correlate(spot, 3, 3, kMinValid)));
  const Image image = TextureImage(20, 20, 2);
  const SpotImage others(image);
  EXPECT_FALSE(std::isnan(others.Correlate(spot, 11, 11, kMinValid)));
  EXPECT_TRUE(std::isnan(others.Correlate(spot, 12, 11, kMinValid)));
  EXPECT_TRUE(std::isnan(others.Correlate(spot, -1, 0, kMinValid)));
}

TEST(RunsOf, AreTheRowsParts) {
  Image image(5, 2, 1);
  image.At(2, 0) = kNoData;
  for (int col = 0; col < 5; ++col) image.At(col, 1) = kNoData;
  const auto runs = RunsOf(image);
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].first, 0);
  EXPECT_EQ(runs[0].stop, 2);
  EXPECT_EQ(runs[1].first, 3);
  EXPECT_EQ(runs[1].stop, 5);
}

}  // namespace
}  // namespace orient
