#include "core/base/csv_cell.h"

#include <gtest/gtest.h>

namespace orient {
namespace {

TEST(CsvCell, IsQuotedWhereItMustBe) {
  EXPECT_EQ(CsvCell("4711"), "4711");
  EXPECT_EQ(CsvCell("a,b"), "\"a,b\"");
  EXPECT_EQ(CsvCell("a\"b"), "\"a\"\"b\"");
  EXPECT_EQ(CsvCell(""), "");
}

TEST(CsvCell, NoSpreadsheetTakesItForAFormula) {
  EXPECT_EQ(CsvCell("=cmd()"), "'=cmd()");
  EXPECT_EQ(CsvCell("=HYPERLINK(\"x\",1)"), "\"'=HYPERLINK(\"\"x\"\",1)\"");
  EXPECT_EQ(CsvCell("@a"), "'@a");
  EXPECT_EQ(CsvCell("-1+cmd"), "'-1+cmd");
  EXPECT_EQ(CsvCell("-12.5"), "-12.5");
  EXPECT_EQ(CsvCell("1e-05"), "1e-05");
}

TEST(CsvCell, ItsTextComesBack) {
  for (const char* text : {"4711", "=a", "'=a", "''=a", "'a", "-1", "-a", "'", ""})
    EXPECT_EQ(TextOfCell(CsvCell(text)), text);
}

}  // namespace
}  // namespace orient
