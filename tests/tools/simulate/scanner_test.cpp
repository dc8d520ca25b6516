#include "tools/simulate/scanner.h"

#include <gtest/gtest.h>

namespace orient::simulation {
namespace {

Image Ramp() {
  Image image(64, 64);
  for (int row = 0; row < 64; ++row)
    for (int col = 0; col < 64; ++col) image.At(col, row) = static_cast<float>(col) / 63;
  return image;
}

TEST(Scanner, NegativeIsTheComplement) {
  ScannerOptions options;
  options.grain = 0;
  const auto positive = Scan(Ramp(), options);
  options.negative = true;
  const auto negative = Scan(Ramp(), options);
  for (size_t i = 0; i < positive.size(); ++i) EXPECT_NEAR(positive[i] + negative[i], 255, 1);
}

TEST(Scanner, SixteenBitsUseTheirRange) {
  ScannerOptions options;
  options.grain = 0;
  options.bits = 16;
  const auto grey = Scan(Ramp(), options);
  EXPECT_EQ(grey[0], 0);
  EXPECT_EQ(grey[63], 65535);
}

TEST(Scanner, GrainHasTheSigmaAskedForAndNoMean) {
  ScannerOptions options;
  options.grain = 5;
  const auto grey = Scan(Image(300, 300, 0.5f), options);
  double sum = 0, squares = 0;
  for (const auto value : grey) {
    sum += value - 127.5;
    squares += (value - 127.5) * (value - 127.5);
  }
  const double n = static_cast<double>(grey.size());
  EXPECT_NEAR(sum / n, 0, 0.15);
  EXPECT_NEAR(std::sqrt(squares / n), 5, 0.2);
}

TEST(Scanner, BlurSpreadsAPointByItsSigmaAndKeepsItsSum) {
  Image image(41, 41);
  image.At(20, 20) = 1;
  Blur(1.5, &image);
  double sum = 0, spread = 0;
  for (int row = 0; row < 41; ++row)
    for (int col = 0; col < 41; ++col) {
      sum += image.At(col, row);
      spread += static_cast<double>(image.At(col, row)) * (col - 20) * (col - 20);
    }
  EXPECT_NEAR(sum, 1, 1e-4);
  EXPECT_NEAR(std::sqrt(spread), 1.5, 0.03);
}

}  // namespace
}  // namespace orient::simulation
