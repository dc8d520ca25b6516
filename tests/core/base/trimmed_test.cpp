#include "core/base/trimmed.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(Trimmed, KeepsWhatStandsBetweenTheBlanks) {
  EXPECT_EQ(Trimmed("\r\n\t a b \t\n"), "a b");
  EXPECT_EQ(Trimmed("a"), "a");
}

TEST(Trimmed, OfNothingOrBlanksIsEmpty) {
  EXPECT_EQ(Trimmed(""), "");
  EXPECT_EQ(Trimmed(" \r\n\t"), "");
}

}  // namespace
}  // namespace orient
