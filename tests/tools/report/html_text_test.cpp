#include "tools/report/html_text.h"

#include <gtest/gtest.h>

#include <limits>

namespace orient {
namespace {

TEST(HtmlText, MarkupIsEscaped) {
  EXPECT_EQ(Escape("<b title=\"a\">&'</b>"), "&lt;b title=&quot;a&quot;&gt;&amp;&#39;&lt;/b&gt;");
}

TEST(HtmlText, BytesThatAreNotUtf8AreReplaced) {
  const std::string replaced = "\xEF\xBF\xBD";
  EXPECT_EQ(Escape("a\xFF"
                   "b"),
            "a" + replaced + "b");
  EXPECT_EQ(Escape("\xE2\x82"), replaced + replaced);  // cut off
  EXPECT_EQ(Escape("\xC0\xAF"), replaced + replaced);  // overlong
  EXPECT_EQ(Escape(std::string("\0\x1B", 2)), replaced + replaced);
  EXPECT_EQ(Escape("é€😀"), "é€😀");
}

TEST(HtmlText, RoundedZeroHasNoSign) {
  EXPECT_EQ(Decimal(-0.004, 2), "0.00");
  EXPECT_EQ(Decimal(-0.006, 2), "−0.01");
  EXPECT_EQ(Grouped(-0.4, 0), "0");
  EXPECT_EQ(SvgNumber(-0.01), "0");
}

TEST(HtmlText, NumbersThatAreNoneAreADash) {
  EXPECT_EQ(Decimal(std::numeric_limits<double>::quiet_NaN(), 2), kNoValue);
  EXPECT_EQ(Decimal(std::optional<double>(), 2), kNoValue);
}

TEST(HtmlText, ThousandsAreGrouped) {
  const std::string space = "\xE2\x80\xAF";
  EXPECT_EQ(Grouped(5000321, 0), "5" + space + "000" + space + "321");
  EXPECT_EQ(Grouped(321.5, 1), "321.5");
  EXPECT_EQ(Grouped(-1234.56, 1), "−1" + space + "234.6");
}

TEST(HtmlText, SigmasShowTwoDigits) {
  EXPECT_EQ(DecimalsForSigma(0.42), 2);
  EXPECT_EQ(DecimalsForSigma(0.0031), 4);
  EXPECT_EQ(DecimalsForSigma(42), 0);
  EXPECT_EQ(DecimalsForSigma(4200), 0);
}

TEST(HtmlText, NumbersOfAVectorStandSideBySide) {
  EXPECT_EQ(Decimals({0.125, -2, 3.004}, 2), "0.12 / −2.00 / 3.00");
}

TEST(HtmlText, TextsAreJoined) {
  EXPECT_EQ(Joined({"a", "b"}), "a; b");
  EXPECT_EQ(Joined({}), "");
}

TEST(HtmlText, LinksStayInTheFolder) {
  EXPECT_EQ(PercentEncoded("a b\"<.png"), "./a%20b%22%3C.png");
  EXPECT_EQ(PercentEncoded("javascript:x"), "./javascript%3Ax");
  EXPECT_EQ(PercentEncoded("a/b"), "./a%2Fb");
  EXPECT_EQ(PercentEncodedPath("ortho/a b.tif"), "./ortho/a%20b.tif");
}

}  // namespace
}  // namespace orient
