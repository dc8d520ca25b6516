#include "core/base/binomial.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace orient {
namespace {

TEST(UpperBoundOfRate, IsCertaintyWhereNothingWasTriedOrAllWasFound) {
  EXPECT_EQ(UpperBoundOfRate(0, 0, 0.001), 1);
  EXPECT_EQ(UpperBoundOfRate(50, 50, 0.001), 1);
}

// (1 - p)^n = 0.001.
TEST(UpperBoundOfRate, OfNoneFoundIsInClosedForm) {
  EXPECT_NEAR(UpperBoundOfRate(0, 100, 0.001), 1 - std::pow(0.001, 0.01), 1e-9);
  EXPECT_NEAR(UpperBoundOfRate(0, 1, 0.001), 0.999, 1e-9);
}

TEST(UpperBoundOfRate, GrowsWithWhatIsFoundAndFallsWithWhatIsTried) {
  EXPECT_LT(UpperBoundOfRate(5, 100, 0.001), UpperBoundOfRate(10, 100, 0.001));
  EXPECT_LT(UpperBoundOfRate(10, 200, 0.001), UpperBoundOfRate(5, 100, 0.001));
  EXPECT_GT(UpperBoundOfRate(10, 200, 0.001), 0.05);
}

TEST(LogTailBound, LiesAboveTheBinomialTailAndNotFarAbove) {
  const int n = 40;
  const double p = 0.1;
  const auto exactly = [&](int k) {
    return std::exp(std::lgamma(n + 1.0) - std::lgamma(k + 1.0) - std::lgamma(n - k + 1.0) +
                    k * std::log(p) + (n - k) * std::log(1 - p));
  };
  for (const int count : {8, 12, 20, 40}) {
    double sum = 0;
    for (int k = count; k <= n; ++k) sum += exactly(k);
    const double tail = std::log(sum);
    const double bound = LogTailBound(std::vector<double>(n, p), count);
    EXPECT_GE(bound, tail - 1e-9) << count;
    EXPECT_LE(bound, tail + 3) << count;
  }
}

TEST(LogTailBound, OfAsManyAsAreExpectedIsCertainty) {
  EXPECT_EQ(LogTailBound({0.5, 0.5, 1, 1}, 3), 0);
  EXPECT_EQ(LogTailBound({}, 0), 0);
}

// A mean would let the good ones vouch for the poor ones.
TEST(LogTailBound, EventsThatAlwaysHappenProveNothing) {
  const std::vector<double> good(10, 0.01);
  std::vector<double> with_certain = good;
  with_certain.insert(with_certain.end(), 5, 1.0);
  EXPECT_NEAR(LogTailBound(with_certain, 11), LogTailBound(good, 6), 1e-6);
}

}  // namespace
}  // namespace orient
