#include "tools/simulate/noise.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/shared_data.h"

namespace orient::simulation {
namespace {

TEST(Noise, FloorIntGoesDownBelowZeroToo) {
  EXPECT_EQ(FloorInt(2.7f), 2);
  EXPECT_EQ(FloorInt(-0.1f), -1);
  EXPECT_EQ(FloorInt(-3.0f), -3);
}

TEST(Noise, ValueNoiseIsContinuousAndBounded) {
  float largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const float x = 0.013f * static_cast<float>(i) - 11;
    const float value = ValueNoise(3, x, 0.4f * x);
    largest = std::max(largest, std::abs(value));
    EXPECT_LT(std::abs(ValueNoise(3, x + 0.001f, 0.4f * x) - value), 0.01f);
  }
  EXPECT_LE(largest, 1);
  EXPECT_GT(largest, 0.5f);
}

TEST(Noise, GaussianHasMeanZeroAndSigmaOne) {
  RandomStream random(TestSeed());
  double sum = 0, squares = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const double value = random.Gaussian();
    sum += value;
    squares += value * value;
  }
  EXPECT_NEAR(sum / kDraws, 0, 4 / std::sqrt(kDraws));
  EXPECT_NEAR(squares / kDraws, 1, 4 * std::sqrt(2.0 / kDraws));
}

TEST(Noise, TheSameSeedGivesTheSameNumbersOnEveryMachine) {
  RandomStream random(1);
  EXPECT_EQ(random.Next(), 0x910a2dec89025cc1ull);  // published SplitMix64 sequence
  EXPECT_EQ(random.Next(), 0xbeeb8da1658eec67ull);
}

}  // namespace
}  // namespace orient::simulation
