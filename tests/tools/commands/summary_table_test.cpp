#include "tools/commands/summary_table.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>
#include <stdexcept>

namespace orient {
namespace {

std::string Printed(const SummaryTable& table) {
  std::ostringstream out;
  table.Print(out);
  return out.str();
}

TEST(SummaryTable, TextStandsLeftAndNumbersRight) {
  SummaryTable table({"photo", "status", "sigma0"});
  table.AddRow({"4711", "ok", "4.1"});
  table.AddRow({"a-longer-name", "failed", "-"});
  EXPECT_EQ(Printed(table),
            "photo          status  sigma0\n"
            "4711           ok         4.1\n"
            "a-longer-name  failed       -\n");
}

TEST(SummaryTable, LettersBeyondAsciiTakeOnePlaceEach) {
  SummaryTable table({"photo", "note"});
  table.AddRow({"Zürich", "x"});
  table.AddRow({"Bern..", "y"});
  EXPECT_EQ(Printed(table), "photo   note\nZürich  x\nBern..  y\n");
}

TEST(SummaryTable, AHeaderAloneIsATable) { EXPECT_EQ(Printed(SummaryTable({"a", "b"})), "a  b\n"); }

TEST(SummaryTable, ARowOfAnotherLengthIsTheCallersMistake) {
  SummaryTable table({"a", "b"});
  EXPECT_THROW(table.AddRow({"1"}), std::invalid_argument);
}

TEST(SummaryTable, NumbersThatAreNotKnownAreADash) {
  EXPECT_EQ(Fixed(1.005, 1), "1.0");
  EXPECT_EQ(Fixed(std::nullopt, 2), "-");
  EXPECT_EQ(Fixed(std::numeric_limits<double>::quiet_NaN(), 2), "-");
}

TEST(MessageCell, TellsWhatDecidesTheStatusBeforeRemarks) {
  EXPECT_EQ(MessageCell({}), "");
  const Finding remark{.reason = Reason::kPrincipalDistanceNotConverged};
  const Finding weak{.reason = Reason::kPrincipalDistanceNotEstimated, .at_best = Status::kWeak};
  EXPECT_EQ(MessageCell({remark}), Sentence(remark));
  EXPECT_EQ(MessageCell({remark, weak}), Sentence(weak) + " (+1 more)");
}

}  // namespace
}  // namespace orient
