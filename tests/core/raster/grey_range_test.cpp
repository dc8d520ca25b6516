#include "core/raster/grey_range.h"

#include <gtest/gtest.h>

#include <numeric>

namespace orient {
namespace {

TEST(GreyRange, LeavesOutTheDarkestAndBrightestHundredth) {
  Image image(20, 10);
  std::iota(image.values.rbegin(), image.values.rend(), 0.0f);  // 0 to 199
  EXPECT_EQ(GreyRange(image), std::pair(2.0f, 197.0f));
}

TEST(GreyRange, PassesOverPixelsWithoutData) {
  Image image(10, 1, kNoData);
  image.At(3, 0) = 7;
  image.At(8, 0) = 5;
  EXPECT_EQ(GreyRange(image), std::pair(5.0f, 7.0f));
}

TEST(GreyRange, OfAnEvenImageHasNoWidth) {
  EXPECT_EQ(GreyRange(Image(4, 4, 100)), std::pair(100.0f, 100.0f));
}

TEST(GreyRange, OfNoDataIsNone) {
  EXPECT_EQ(GreyRange(Image(4, 4, kNoData)), std::pair(0.0f, 0.0f));
}

}  // namespace
}  // namespace orient
