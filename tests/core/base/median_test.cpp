#include "core/base/median.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>

namespace orient {
namespace {

TEST(Median, OfOneValueIsThatValue) {
  EXPECT_EQ(Median({7}), 7);
  EXPECT_EQ(UpperMedian({7}), 7);
}

TEST(Median, OfAnOddNumberIsTheOneInTheMiddle) {
  EXPECT_EQ(Median({9, -1, 4, 4, 100}), 4);
  EXPECT_EQ(UpperMedian({9, -1, 4, 4, 100}), 4);
}

TEST(Median, OfAnEvenNumberIsTheMeanOfTheTwoInTheMiddle) { EXPECT_EQ(Median({8, 1, 2, 5}), 3.5); }

TEST(UpperMedian, OfAnEvenNumberIsTheGreaterOfTheTwoInTheMiddle) {
  EXPECT_EQ(UpperMedian({8, 1, 2, 5}), 5);
}

TEST(LowerQuartile, IsTheValueThatAQuarterAreBelow) {
  EXPECT_EQ(LowerQuartile({7}), 7);
  EXPECT_EQ(LowerQuartile({8, 1, 2, 5}), 2);
  EXPECT_EQ(LowerQuartile({3, 9, 1, 8, 2, 7, 6, 5, 4}), 3);
}

TEST(Robust, SigmaIsThatOfMostValues) {
  const RobustValue robust = Robust({9, -1, 4, 5, 100});
  EXPECT_EQ(robust.median, 5);
  EXPECT_EQ(robust.sigma, 4 * kSigmaOfMedianDeviation);
}

TEST(Median, IsThatOfTheSortedValues) {
  EXPECT_TRUE(rc::check([] {
    const auto whole = *rc::gen::nonEmpty<std::vector<int>>();
    std::vector<double> values(whole.begin(), whole.end()), sorted = values;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t half = sorted.size() / 2;
    RC_ASSERT(UpperMedian(values) == sorted[half]);
    RC_ASSERT(Median(values) == (sorted[half] + sorted[sorted.size() - 1 - half]) / 2);
  }));
}

}  // namespace
}  // namespace orient
