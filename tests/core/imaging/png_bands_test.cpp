#include "core/imaging/png_bands.h"

#include <gtest/gtest.h>

#include <random>
#include <stdexcept>

#include "core/error.h"
#include "core/imaging/raster.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

Image Noise(int width, int height, int largest, std::mt19937& random) {
  Image image(width, height);
  for (float& value : image.values)
    value = static_cast<float>(random() % static_cast<unsigned>(largest + 1));
  return image;
}

TEST(PngBands, GreyAndColourOf8And16BitsAreLossless) {
  std::mt19937 random(TestSeed());
  for (const int bits : {8, 16})
    for (const int count : {1, 3}) {
      std::vector<Image> bands;
      for (int i = 0; i < count; ++i) bands.push_back(Noise(13, 7, (1 << bits) - 1, random));
      const auto read = DecodePngBands(EncodePngBands(bands, bits));
      ASSERT_EQ(read.size(), bands.size());
      for (std::size_t i = 0; i < bands.size(); ++i) {
        EXPECT_EQ(read[i].width, 13);
        EXPECT_EQ(read[i].values, bands[i].values);
      }
    }
}

TEST(PngBands, GreyIsTheRastersGrey) {
  std::mt19937 random(TestSeed());
  const std::vector<Image> bands = {Noise(9, 9, 255, random), Noise(9, 9, 255, random),
                                    Noise(9, 9, 255, random)};
  const Image grey = GreyOfBands(bands), raster = DecodePng(EncodePngBands(bands, 8));
  for (std::size_t i = 0; i < grey.values.size(); ++i)
    EXPECT_NEAR(grey.values[i], raster.values[i], 1e-4);
}

TEST(PngBands, EveryTruncationAndDamageIsAnInputErrorOrAPicture) {
  std::mt19937 random(TestSeed());
  const auto png = EncodePngBands({Noise(21, 21, 255, random)}, 8);
  for (std::size_t size = 0; size + 20 < png.size(); size += 7)
    EXPECT_THROW(DecodePngBands({png.begin(), png.begin() + static_cast<std::ptrdiff_t>(size)}),
                 InputError)
        << size;
  for (int round = 0; round < 300; ++round) {
    auto damaged = png;
    for (int i = 0; i < 3; ++i)
      damaged[random() % damaged.size()] = static_cast<unsigned char>(random());
    try {
      DecodePngBands(damaged);
    } catch (const InputError&) {
    }
  }
}

TEST(PngBands, BandsOfDifferentSizesAreRefused) {
  EXPECT_THROW(EncodePngBands({Image(3, 3), Image(3, 3), Image(3, 4)}, 8), std::invalid_argument);
  EXPECT_THROW(EncodePngBands({Image(3, 3), Image(3, 3)}, 8), std::invalid_argument);
  EXPECT_THROW(EncodePngBands({}, 8), std::invalid_argument);
}

}  // namespace
}  // namespace orient
