#include "core/files/finding.h"

#include <gtest/gtest.h>

#include <set>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/files/results.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

TEST(Finding, EveryReasonHasACodeOfItsOwnAndASentence) {
  std::set<std::string_view> codes;
  int place = 0;
  for (const Reason reason : AllReasons()) {
    EXPECT_EQ(static_cast<int>(reason), place++) << "the wordings are in the order of Reason";
    EXPECT_TRUE(codes.insert(Code(reason)).second) << Code(reason);
    EXPECT_EQ(ReasonFromCode(Code(reason)), reason);
    EXPECT_FALSE(Sentence({reason, Status::kWeak, 1.5, 2.5, "somewhere"}).empty());
  }
}

TEST(Finding, ACodeThatNoReasonHasIsNone) {
  for (const char* code : {"", "no_such_reason", "Stated", "stated ", "state"})
    EXPECT_EQ(ReasonFromCode(code), std::nullopt) << code;
}

TEST(Finding, TheSentenceHasItsFigures) {
  EXPECT_EQ(Sentence({Reason::kFewMarks, Status::kWeak, 3, 4}),
            "Only 3 marks could be used; 4 are needed.");
  EXPECT_EQ(Sentence({Reason::kFewMarks, Status::kFailed, 1, 3, "2, 3, 4"}),
            "Only 1 mark could be used; 3 are needed; not found or rejected: 2, 3, 4.");
  EXPECT_EQ(Sentence({.reason = Reason::kStated, .where = "as it was {}"}), "as it was {}");
}

TEST(Finding, TheSentenceSpeaksOfOneOrMany) {
  const auto said = [](double count) {
    return Sentence({.reason = Reason::kLocatedByOwnFiles, .value = count});
  };
  EXPECT_EQ(said(1), "1 photo is located by the GNSS position in its own file");
  EXPECT_EQ(said(2), "2 photos are located by the GNSS position in their own files");
  EXPECT_EQ(
      Sentence({.reason = Reason::kPartWithoutDatum, .value = 2, .where = "a and b"}),
      "Photos a and b are adjusted apart from the rest of the block. They have too little control "
      "for position, attitude and scale.");
  EXPECT_EQ(Sentence({.reason = Reason::kPartNotConnected, .value = 1, .where = "a"}),
            "Photo a is not connected to the rest of the block.");
}

TEST(Finding, TheSentenceSaysOfWhatAndWhat) {
  EXPECT_EQ(Sentence({.reason = Reason::kApproximationsOfOtherPhotos,
                      .value = 2,
                      .where = "out/approx.csv: ghost, phantom"}),
            "out/approx.csv lists 2 photos that are not in the block: ghost, phantom");
  EXPECT_EQ(Sentence({.reason = Reason::kAngleColumnsIgnored, .value = 1, .where = "a.csv: yaw"}),
            "a.csv has 1 column that is ignored, since only omega, phi and kappa in degrees are "
            "read: yaw");
  EXPECT_EQ(Sentence({.reason = Reason::kRowsWithoutPosition, .value = 2, .where = "a.csv: 1, 2"}),
            "a.csv has no complete position of 2 photos, which are treated as if not listed: 1, 2");
  EXPECT_EQ(Sentence({.reason = Reason::kNoTiesFromPhoto, .where = "4711: it: is lost"}),
            "4711 gives no tie points: it: is lost");
  EXPECT_EQ(Sentence({.reason = Reason::kNoTiesFromPhoto, .where = "4711"}),
            "4711 gives no tie points: ");
}

TEST(Finding, TheStatusIsTheWorstThatIsAllowed) {
  EXPECT_EQ(StatusOf({}), Status::kOk);
  EXPECT_EQ(StatusOf({{Reason::kFilmDistorted}, {Reason::kFewMarks, Status::kWeak}}),
            Status::kWeak);
  EXPECT_EQ(StatusOf({{Reason::kNoPatches, Status::kFailed}, {Reason::kFewMarks, Status::kWeak}}),
            Status::kFailed);
}

TEST(Finding, TheStatusOfASingleFindingIsItsOwn) {
  for (const Status status : {Status::kOk, Status::kWeak, Status::kFailed})
    EXPECT_EQ(StatusOf({{Reason::kStated, status}}), status);
}

TEST(Finding, SentencesAreJoinedInTheirOrder) {
  const Findings findings = {{.reason = Reason::kStated, .where = "one"},
                             {.reason = Reason::kScanUnusable, .where = "two"}};
  EXPECT_EQ(Sentences(findings), (std::vector<std::string>{"one", "two"}));
  EXPECT_EQ(JoinedSentences(findings), "one; two");
  EXPECT_EQ(JoinedSentences({}), "");
  EXPECT_TRUE(Has(findings, Reason::kScanUnusable));
  EXPECT_FALSE(Has(findings, Reason::kPhotoUnusable));
}

TEST(Finding, EveryCodeIsOnItsPage) {
  const std::string page = ReadFile(ProjectFile("docs/findings.md"));
  for (const Reason reason : AllReasons())
    EXPECT_NE(page.find("`" + std::string(Code(reason)) + "`"), std::string::npos) << Code(reason);
}

TEST(Finding, IsReadFromAResultAsItWasWritten) {
  const TemporaryFolder folder;
  ExteriorResult result;
  result.photo = "4711";
  result.status = Status::kFailed;
  result.findings = {{Reason::kBelowGround, Status::kFailed, 120.5, 300.25, " in approx.csv"},
                     {.reason = Reason::kNotLearnt, .where = "disk full"}};
  WriteExteriorResult(folder.Path(), result);
  EXPECT_EQ(ReadExteriorResult(ExteriorResultPath(folder.Path(), "4711")).findings,
            result.findings);
}

TEST(Finding, OfAReasonThatThisVersionDoesNotKnowIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "1.exterior.json";
  WriteFileAtomically(path, R"({"photo": "1", "status": "weak", "iterations": [], "patches": [],
                               "findings": [{"code": "of_tomorrow", "at_best": "weak"}]})");
  ExpectError<InputError>([&] { ReadExteriorResult(path); }, {"1.exterior.json", "of_tomorrow"});
}

TEST(Finding, OfAResultOfAnotherMakerTheMessagesStand) {
  const TemporaryFolder folder;
  const std::string path = folder / "1.exterior.json";
  WriteFileAtomically(path, R"({"photo": "1", "status": "weak", "iterations": [], "patches": [],
                               "messages": ["measured by hand"]})");
  const Findings findings = ReadExteriorResult(path).findings;
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].reason, Reason::kStated);
  EXPECT_EQ(Sentence(findings[0]), "measured by hand");
}

}  // namespace
}  // namespace orient
