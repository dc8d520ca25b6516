#include "core/base/date.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(DateProblem, IsEmptyForYearMonthAndDay) {
  for (const char* date :
       {"1961", "1961-07", "1961-12", "1961-07-30", "2020-01-01", "1960-02-29", "0001-10-31"})
    EXPECT_EQ(DateProblem(date), "") << date;
}

TEST(DateProblem, NamesWhatIsNone) {
  for (const char* text : {"", "61", "19610730", "1961-7", "1961-00", "1961-13", "1961-07-00",
                           "1961-07-32", "1961-02-29", "1961-04-31", "1961/07/30", "1961-07-",
                           "1961-07-3", "1961-07-301", "196a", "-961", "1961-0:", "30.7.1961"})
    EXPECT_NE(DateProblem(text).find("not a date"), std::string::npos) << text;
}

}  // namespace
}  // namespace orient
