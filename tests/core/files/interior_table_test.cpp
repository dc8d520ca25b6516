#include "core/files/interior_table.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace orient {
namespace {

InteriorResult Result() {
  InteriorResult result;
  result.photo = "47,11";
  result.status = Status::kWeak;
  result.width = 9200;
  result.height = 9100;
  result.photo_from_pixel = Affine2d{Eigen::Matrix2d{{0.025, 1e-5}, {2e-5, -0.025}}, {-115, 114.5}};
  result.sigma0_um = 4.125;
  MarkResult mark;
  mark.id = "1";
  mark.state = MarkState::kUsed;
  mark.pixel = Eigen::Vector2d(12.25, 13.5);
  result.marks = {mark, MarkResult{"2", MarkState::kMissing, {}, {}, {}, {}}};
  result.findings = {{.reason = Reason::kStated, .where = "It says \"no\"."},
                     {.reason = Reason::kStated, .where = "And, again."}};
  return result;
}

// Commas outside quotes, line by line.
std::vector<int> CellsPerLine(const std::string& text) {
  std::vector<int> cells;
  bool quoted = false;
  int count = 1;
  for (const char c : text) {
    if (c == '"') quoted = !quoted;
    if (c == ',' && !quoted) ++count;
    if (c == '\n' && !quoted) {
      cells.push_back(count);
      count = 1;
    }
  }
  return cells;
}

TEST(InteriorTable, EveryRowHasTheHeadersCells) {
  for (const std::string& text :
       {InteriorTable({Result(), InteriorResult()}), MarkTable({Result()}, {})}) {
    const std::vector<int> cells = CellsPerLine(text);
    ASSERT_EQ(cells.size(), 3U) << text;
    EXPECT_EQ(cells[1], cells[0]) << text;
    EXPECT_EQ(cells[2], cells[0]) << text;
  }
}

TEST(InteriorTable, ARowHoldsStatusTransformAndQuotedText) {
  const std::string text = InteriorTable({Result()});
  EXPECT_NE(text.find("\"47,11\",weak,9200,9100,"), std::string::npos) << text;
  EXPECT_NE(text.find(",0.025,1e-05,2e-05,-0.025,-115,114.5,4.12,"), std::string::npos) << text;
  EXPECT_NE(text.find("\"It says \"\"no\"\". And, again.\""), std::string::npos) << text;
}

TEST(InteriorTable, TheTransformOfTheFirstOfSeveralOrientationsIsNoResult) {
  InteriorResult open = Result();
  open.possible_orientations = {ScanOrientation::kM90, ScanOrientation::kR0};
  const std::string text = InteriorTable({open});
  EXPECT_NE(text.find(",open,m90 r0,,,,,,,4.12,"), std::string::npos) << text;
}

TEST(InteriorTable, AMarksRowHoldsWhereItIsInScanAndCamera) {
  const std::string text =
      MarkTable({Result()}, {{"2", {5, 6}, "m", {}}, {"1", {-106.004, 105.5}, "m", {}}});
  EXPECT_NE(text.find("\"47,11\",1,used,12.2500,13.5000,,,-106.00400,105.50000,,,\n"),
            std::string::npos)
      << text;
  EXPECT_NE(text.find("\"47,11\",2,missing,,,,,5.00000,6.00000,,,\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace orient
