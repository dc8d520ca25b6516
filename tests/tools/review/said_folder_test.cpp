#include "tools/review/said_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <random>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

Word MarkWord(const std::string& mark, double col) {
  Word word;
  word.marks = {{"4711", mark, {col, 20.5}, 1, false, {"J", "2024-05-01"}}};
  word.about = "mark " + mark;
  return word;
}

Word DecisionWord(DecisionKind kind, const std::string& value = "") {
  Word word;
  word.decisions = {{"4711", kind, value, "seen", {"J", "2024"}}};
  return word;
}

class SaidFolderTest : public testing::Test {
 protected:
  std::string Path() const { return folder_ / "said"; }
  // With the version of now.
  static SayOutcome Say(SaidFolder* said, const Word& word) {
    return said->Say(said->Read().second, word);
  }
  static SayOutcome Undo(SaidFolder* said) { return said->Undo(said->Read().second); }

  TemporaryFolder folder_;
};

TEST_F(SaidFolderTest, MakesTheFolderAndWritesNothingBeforeAWord) {
  SaidFolder said(Path());
  EXPECT_TRUE(said.Read().first.marks.empty());
  EXPECT_FALSE(fs::exists(Path() + "/marks.csv"));
  EXPECT_EQ(Undo(&said), SayOutcome::kNothing);
}

TEST_F(SaidFolderTest, AWordIsInTheFilesOnceItIsConfirmed) {
  SaidFolder said(Path());
  ASSERT_EQ(Say(&said, MarkWord("3", 10.25)), SayOutcome::kSaid);
  const Measurements read = ReadMeasurements(Path());
  ASSERT_EQ(read.marks.size(), 1u);
  EXPECT_EQ(read.marks[0].pixel, Eigen::Vector2d(10.25, 20.5));
  EXPECT_EQ(read.marks[0].said.by, "J");
  EXPECT_EQ(said.LatestAbout(), "mark 3");
}

TEST_F(SaidFolderTest, TheSameThingSaidAgainReplacesTheFirst) {
  SaidFolder said(Path());
  Say(&said, MarkWord("3", 10));
  Say(&said, MarkWord("4", 11));
  Say(&said, MarkWord("3", 12));
  const auto marks = ReadMeasurements(Path()).marks;
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks[1].pixel.x(), 12);
  Say(&said, DecisionWord(DecisionKind::kAccept));
  Say(&said, DecisionWord(DecisionKind::kReject));
  Say(&said, DecisionWord(DecisionKind::kOrientation, "r90"));
  const auto decisions = ReadMeasurements(Path()).decisions;
  ASSERT_EQ(decisions.size(), 2u);
  EXPECT_EQ(decisions[0].kind, DecisionKind::kReject);
}

TEST_F(SaidFolderTest, OneOfTwoWindowsIsToldThatTheOtherSpoke) {
  SaidFolder said(Path());
  const std::string both_read = said.Read().second;
  ASSERT_EQ(said.Say(both_read, MarkWord("1", 5)), SayOutcome::kSaid);
  EXPECT_EQ(said.Say(both_read, MarkWord("1", 99)), SayOutcome::kOtherVersion);
  EXPECT_EQ(said.Undo(both_read), SayOutcome::kOtherVersion);
  EXPECT_EQ(ReadMeasurements(Path()).marks.at(0).pixel.x(), 5);
}

TEST_F(SaidFolderTest, AnEditByHandIsAnotherVersionAndStays) {
  SaidFolder said(Path());
  Say(&said, MarkWord("1", 5));
  const std::string version = said.Read().second;
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\n4711,1,6,7,1\n");
  EXPECT_EQ(said.Say(version, MarkWord("2", 5)), SayOutcome::kOtherVersion);
  EXPECT_EQ(Undo(&said), SayOutcome::kOtherVersion) << "it would take the edit back";
  EXPECT_EQ(Say(&said, MarkWord("2", 8)), SayOutcome::kSaid);
  EXPECT_EQ(ReadMeasurements(Path()).marks.size(), 2u);
}

TEST_F(SaidFolderTest, UndoTakesWordsBackOneByOne) {
  SaidFolder said(Path());
  Say(&said, MarkWord("1", 5));
  const std::string one = ReadFile(Path() + "/marks.csv");
  Word point;
  point.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl, {}}};
  point.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  Say(&said, point);
  Say(&said, MarkWord("1", 50));
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), one);
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_FALSE(fs::exists(Path() + "/points.csv"));
  EXPECT_FALSE(fs::exists(Path() + "/image_points.csv"));
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_FALSE(fs::exists(Path() + "/marks.csv"));
  EXPECT_EQ(Undo(&said), SayOutcome::kNothing);
}

TEST_F(SaidFolderTest, WordsOfAnEarlierReviewAreTakenBackAsLongAsNobodyElseChangedTheFiles) {
  {
    SaidFolder said(Path());
    Say(&said, MarkWord("1", 5));
    Say(&said, MarkWord("2", 6));
    Say(&said, DecisionWord(DecisionKind::kReject));
    ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  }
  {
    SaidFolder said(Path());
    EXPECT_EQ(said.LatestAbout(), "mark 2");
    ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
    ASSERT_EQ(said.Read().first.marks.size(), 1u);
    EXPECT_EQ(said.Read().first.marks[0].mark, "1");
  }
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\n4711,1,6,7,1\n");
  SaidFolder said(Path());
  EXPECT_EQ(said.LatestAbout(), "");
  EXPECT_EQ(Undo(&said), SayOutcome::kNothing);
  EXPECT_EQ(said.Read().first.marks.size(), 1u);
}

TEST_F(SaidFolderTest, AHistoryThatIsDamagedOrNoTextCostsNoWord) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/.orient-review.undo.json", "{\"words\": [{\"about\": 3");
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\nfoto\xfc,1,6,7,1\n");
  SaidFolder said(Path());
  EXPECT_EQ(said.LatestAbout(), "");
  ASSERT_EQ(Say(&said, MarkWord("1", 5)), SayOutcome::kSaid);
  Word withdrawn;
  withdrawn.no_marks = {{"foto\xfc", "1"}};
  ASSERT_EQ(Say(&said, withdrawn), SayOutcome::kSaid) << "the line with no UTF-8 is in the history";
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_EQ(said.Read().first.marks.size(), 2u);
}

// Any sequence of words and of reviews, taken back to its beginning.
TEST_F(SaidFolderTest, UndoneToTheEndTheFilesAreAsTheyWereInTheBeginning) {
  fs::create_directory(Path());
  const std::string begin = "# by hand\nphoto,mark,col,row,sigma\n4711,9,6,7,1\n4712,1,6,7,1\n";
  WriteFileAtomically(Path() + "/marks.csv", begin);
  std::mt19937 random(5);
  int words = 0;
  for (int review = 0; review < 8; ++review) {
    SaidFolder said(Path());
    for (int action = 0; action < 6; ++action) {
      const int what = static_cast<int>(random() % 4);
      if (what == 0 && words > 0) {
        ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
        --words;
        continue;
      }
      const std::string mark = std::to_string(random() % 5);
      Word word = what == 1 ? DecisionWord(DecisionKind::kReject) : MarkWord(mark, double(action));
      if (what == 2) word.no_marks = {{"4711", "9"}};
      ASSERT_EQ(Say(&said, word), SayOutcome::kSaid);
      ++words;
    }
  }
  ASSERT_GT(words, 10);
  SaidFolder said(Path());
  for (; words > 0; --words) ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_EQ(Undo(&said), SayOutcome::kNothing);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), begin);
  EXPECT_FALSE(fs::exists(Path() + "/decisions.csv"));
}

TEST_F(SaidFolderTest, CoordinatesAreWithdrawnApartFromThePlaceInThePhoto) {
  SaidFolder said(Path());
  Word point;
  point.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl, {}},
                  {"q", {1, 2, 3}, {1, 1, 1}, PointRole::kCheck, {}}};
  point.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  Say(&said, point);
  Word withdrawn;
  withdrawn.no_points = {"p"};
  ASSERT_EQ(Say(&said, withdrawn), SayOutcome::kSaid);
  const Measurements now = said.Read().first;
  EXPECT_EQ(now.Point("p"), nullptr);
  EXPECT_NE(now.Point("q"), nullptr);
  EXPECT_EQ(now.image_points.size(), 1u);
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_NE(said.Read().first.Point("p"), nullptr);
}

TEST_F(SaidFolderTest, WhatIsWithdrawnIsNotSaidAnyMore) {
  SaidFolder said(Path());
  Say(&said, MarkWord("1", 5));
  Say(&said, DecisionWord(DecisionKind::kAccept));
  Word withdrawn;
  withdrawn.no_marks = {{"4711", "1"}};
  withdrawn.no_decisions = {{"4711", DecisionKind::kAccept}};
  ASSERT_EQ(Say(&said, withdrawn), SayOutcome::kSaid);
  const Measurements read = ReadMeasurements(Path());
  EXPECT_TRUE(read.marks.empty());
  EXPECT_TRUE(read.decisions.empty());
}

TEST_F(SaidFolderTest, KeepsACopyOfAFileThatAPersonHadWritten) {
  fs::create_directory(Path());
  const std::string theirs = "# from the field book\nphoto,mark,col,row,sigma\n4711,1,6,7,1\n";
  WriteFileAtomically(Path() + "/marks.csv", theirs);
  SaidFolder said(Path());
  Say(&said, MarkWord("2", 5));
  Say(&said, MarkWord("3", 5));
  EXPECT_EQ(ReadFile(Path() + "/marks.csv.before_review"), theirs);
  Undo(&said);
  ASSERT_EQ(Undo(&said), SayOutcome::kSaid);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), theirs);
}

TEST_F(SaidFolderTest, WhatTheFilesCannotHoldIsRefusedAndNotWritten) {
  SaidFolder said(Path());
  const auto refused = [&](const Word& word, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { Say(&said, word); }, parts);
  };
  refused(MarkWord("", 5), {"the mark has no name"});
  refused(MarkWord(" 1", 5), {"blanks around"});
  refused(MarkWord("1\n2", 5), {"line breaks"});
  refused(MarkWord(std::string(201, 'x'), 5), {"more than 200"});
  refused(MarkWord("1", std::numeric_limits<double>::quiet_NaN()), {"pixel", "number"});
  refused(MarkWord("1", 1e12), {"pixel"});
  refused(DecisionWord(DecisionKind::kOrientation, "r91"), {"r91", "must be r0"});
  refused(DecisionWord(DecisionKind::kPixelSize, "-3"), {"-3"});
  Word no_sigma = MarkWord("1", 5);
  no_sigma.marks[0].sigma_px = 0;
  refused(no_sigma, {"sigma is 0"});
  EXPECT_TRUE(fs::is_empty(Path()) || !fs::exists(Path() + "/marks.csv"));
  EXPECT_FALSE(fs::exists(Path() + "/decisions.csv"));
}

TEST_F(SaidFolderTest, NamesThatLookLikeMarkupOrFormulasComeBackAsTheyWere) {
  SaidFolder said(Path());
  for (const std::string name : {"<b>1</b>", "=1+1", "a,\"b\"", "#1", "\xC3\xA4"}) {
    ASSERT_EQ(Say(&said, MarkWord(name, 5)), SayOutcome::kSaid) << name;
    EXPECT_EQ(said.Read().first.marks.back().mark, name);
  }
}

TEST_F(SaidFolderTest, ClicksDoNotMixWithPointsOfThePhotoSystem) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/image_points.csv", "photo,point,x_mm,y_mm,sigma\na,p,1,2,1\n");
  SaidFolder said(Path());
  Word word;
  word.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  ExpectError<InputError>([&] { Say(&said, word); }, {"image_points.csv", "--measurements"});
}

TEST_F(SaidFolderTest, TwoReviewsDoNotShareAFolder) {
  const SaidFolder said(Path());
  ExpectError<InputError>([&] { SaidFolder again(Path()); }, {Path()});
}

TEST_F(SaidFolderTest, AWrongFileIsToldWhenTheReviewBegins) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark\n");
  ExpectError<InputError>([&] { SaidFolder said(Path()); }, {"marks.csv, line 1"});
}

}  // namespace
}  // namespace orient
