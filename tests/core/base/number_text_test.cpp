#include "core/base/number_text.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(NumberIn, IsTheWholeText) {
  EXPECT_EQ(NumberIn("-1.5e3"), -1500);
  EXPECT_EQ(NumberIn<int>("42"), 42);
  for (const char* none : {"", " 1", "1 ", "1,5", "0x10", "1.5m", "e", "+1", "--1"})
    EXPECT_EQ(NumberIn(none), std::nullopt) << none;
  for (const char* none : {"1.5", "99999999999", "-"})
    EXPECT_EQ(NumberIn<int>(none), std::nullopt) << none;
}

TEST(NumberIn, IsFinite) {
  for (const char* none : {"inf", "-inf", "nan", "1e999"})
    EXPECT_EQ(NumberIn(none), std::nullopt) << none;
}

TEST(SignedNumberIn, MayHaveOnePlus) {
  EXPECT_EQ(SignedNumberIn("+2.5"), 2.5);
  EXPECT_EQ(SignedNumberIn("-2.5"), -2.5);
  for (const char* none : {"+", "++1", "+-1", "-+1", "+inf"})
    EXPECT_EQ(SignedNumberIn(none), std::nullopt) << none;
}

}  // namespace
}  // namespace orient
