#include "tools/review/page_entries.h"

#include <gtest/gtest.h>

#include "core/base/error.h"
#include "tests/support/expect_error.h"

namespace orient {
namespace {

const Attribution kRecorded = {"J", "2024-05-01"};

TEST(PageEntries, AreReadWithWhoSaysThem) {
  const PageEntry page = EntryOfPage(
      R"({"version": "v", "about": "all",
          "marks": [{"photo": "a", "mark": "3", "pixel": [12.5, 80.5], "sigma": 2, "exact": true}],
          "image_points": [{"photo": "b", "point": "p", "pixel": [1, 2], "sigma": 1}],
          "points": [{"point": "p", "ground": [1, 2, 3], "sigma": [1, 1, 2], "role": "check"}],
          "decisions": [{"photo": "c", "decision": "polarity", "value": "negative", "reason": "r"}],
          "no_marks": [["d", "1"]], "no_image_points": [["e", "q"]],
          "no_decisions": [["f", "pixel_size"]]})",
      kRecorded);
  EXPECT_EQ(page.version, "v");
  const Entry& entry = page.entry;
  ASSERT_EQ(entry.marks.size(), 1u);
  EXPECT_EQ(entry.marks[0].pixel, Eigen::Vector2d(12.5, 80.5));
  EXPECT_TRUE(entry.marks[0].exact);
  EXPECT_EQ(entry.marks[0].attribution.when, "2024-05-01");
  EXPECT_EQ(*entry.image_points.at(0).pixel, Eigen::Vector2d(1, 2));
  EXPECT_EQ(entry.points.at(0).role, PointRole::kCheck);
  EXPECT_EQ(entry.points[0].sigma_m, Eigen::Vector3d(1, 1, 2));
  EXPECT_EQ(entry.decisions.at(0).kind, DecisionKind::kPolarity);
  EXPECT_EQ(entry.no_decisions.at(0).second, DecisionKind::kPixelSize);
  EXPECT_EQ(PhotosOf(entry), (std::vector<std::string>{"a", "b", "c", "d", "e", "f"}));
}

TEST(PageEntries, TellWhatIsWrong) {
  const auto refused = [](const std::string& text, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { EntryOfPage(text, kRecorded); }, parts);
  };
  refused("", {"no JSON"});
  refused("[]", {"no JSON"});
  refused("{}", {"version"});
  refused(R"({"version": 1})", {"version is no text"});
  refused(R"({"version": "v", "marks": 1})", {"marks is not a list"});
  refused(R"({"version": "v", "marks": [1]})", {"photo is missing"});
  refused(R"({"version": "v", "marks": [{"photo": "a", "mark": "1", "pixel": [1], "sigma": 1,
              "exact": false}]})",
          {"pixel must be 2 numbers"});
  refused(R"({"version": "v", "marks": [{"photo": "a", "mark": "1", "pixel": [1, "2"], "sigma": 1,
              "exact": false}]})",
          {"pixel is not a number"});
  refused(R"({"version": "v", "decisions": [{"photo": "a", "decision": "praise", "value": "",
              "reason": ""}]})",
          {"praise"});
  refused(R"({"version": "v", "no_marks": [["a"]]})", {"no_marks", "pairs"});
  refused(std::string(50000, '['), {"no JSON"});
}

}  // namespace
}  // namespace orient
