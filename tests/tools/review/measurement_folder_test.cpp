#include "tools/review/measurement_folder.h"

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

Entry MarkEntry(const std::string& mark, double col) {
  Entry entry;
  entry.marks = {{"4711", mark, {col, 20.5}, 1, false, {"J", "2024-05-01"}}};
  entry.about = "mark " + mark;
  return entry;
}

Entry DecisionEntry(DecisionKind kind, const std::string& value = "") {
  Entry entry;
  entry.decisions = {{"4711", kind, value, "seen", {"J", "2024"}}};
  return entry;
}

class MeasurementFolderTest : public testing::Test {
 protected:
  std::string Path() const { return folder_ / "said"; }
  // With the version of now.
  static EntryOutcome Record(MeasurementFolder* folder, const Entry& entry) {
    return folder->Record(folder->Read().second, entry);
  }
  static EntryOutcome Undo(MeasurementFolder* folder) {
    return folder->Undo(folder->Read().second);
  }

  TemporaryFolder folder_;
};

TEST_F(MeasurementFolderTest, MakesTheFolderAndWritesNothingBeforeAWord) {
  MeasurementFolder folder(Path());
  EXPECT_TRUE(folder.Read().first.marks.empty());
  EXPECT_FALSE(fs::exists(Path() + "/marks.csv"));
  EXPECT_EQ(Undo(&folder), EntryOutcome::kNothing);
}

TEST_F(MeasurementFolderTest, AWordIsInTheFilesOnceItIsConfirmed) {
  MeasurementFolder folder(Path());
  ASSERT_EQ(Record(&folder, MarkEntry("3", 10.25)), EntryOutcome::kRecorded);
  const Measurements read = ReadMeasurements(Path());
  ASSERT_EQ(read.marks.size(), 1u);
  EXPECT_EQ(read.marks[0].pixel, Eigen::Vector2d(10.25, 20.5));
  EXPECT_EQ(read.marks[0].attribution.by, "J");
  EXPECT_EQ(folder.LatestAbout(), "mark 3");
}

TEST_F(MeasurementFolderTest, TheSameThingSaidAgainReplacesTheFirst) {
  MeasurementFolder folder(Path());
  Record(&folder, MarkEntry("3", 10));
  Record(&folder, MarkEntry("4", 11));
  Record(&folder, MarkEntry("3", 12));
  const auto marks = ReadMeasurements(Path()).marks;
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks[1].pixel.x(), 12);
  Record(&folder, DecisionEntry(DecisionKind::kAccept));
  Record(&folder, DecisionEntry(DecisionKind::kReject));
  Record(&folder, DecisionEntry(DecisionKind::kOrientation, "r90"));
  const auto decisions = ReadMeasurements(Path()).decisions;
  ASSERT_EQ(decisions.size(), 2u);
  EXPECT_EQ(decisions[0].kind, DecisionKind::kReject);
}

TEST_F(MeasurementFolderTest, OneOfTwoWindowsIsToldThatTheOtherSpoke) {
  MeasurementFolder folder(Path());
  const std::string both_read = folder.Read().second;
  ASSERT_EQ(folder.Record(both_read, MarkEntry("1", 5)), EntryOutcome::kRecorded);
  EXPECT_EQ(folder.Record(both_read, MarkEntry("1", 99)), EntryOutcome::kOtherVersion);
  EXPECT_EQ(folder.Undo(both_read), EntryOutcome::kOtherVersion);
  EXPECT_EQ(ReadMeasurements(Path()).marks.at(0).pixel.x(), 5);
}

TEST_F(MeasurementFolderTest, AnEditByHandIsAnotherVersionAndStays) {
  MeasurementFolder folder(Path());
  Record(&folder, MarkEntry("1", 5));
  const std::string version = folder.Read().second;
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\n4711,1,6,7,1\n");
  EXPECT_EQ(folder.Record(version, MarkEntry("2", 5)), EntryOutcome::kOtherVersion);
  EXPECT_EQ(Undo(&folder), EntryOutcome::kOtherVersion) << "it would take the edit back";
  EXPECT_EQ(Record(&folder, MarkEntry("2", 8)), EntryOutcome::kRecorded);
  EXPECT_EQ(ReadMeasurements(Path()).marks.size(), 2u);
}

TEST_F(MeasurementFolderTest, UndoTakesWordsBackOneByOne) {
  MeasurementFolder folder(Path());
  Record(&folder, MarkEntry("1", 5));
  const std::string one = ReadFile(Path() + "/marks.csv");
  Entry point;
  point.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl, {}}};
  point.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  Record(&folder, point);
  Record(&folder, MarkEntry("1", 50));
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), one);
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_FALSE(fs::exists(Path() + "/points.csv"));
  EXPECT_FALSE(fs::exists(Path() + "/image_points.csv"));
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_FALSE(fs::exists(Path() + "/marks.csv"));
  EXPECT_EQ(Undo(&folder), EntryOutcome::kNothing);
}

TEST_F(MeasurementFolderTest, WordsOfAnEarlierReviewAreTakenBackAsLongAsNobodyElseChangedTheFiles) {
  {
    MeasurementFolder folder(Path());
    Record(&folder, MarkEntry("1", 5));
    Record(&folder, MarkEntry("2", 6));
    Record(&folder, DecisionEntry(DecisionKind::kReject));
    ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  }
  {
    MeasurementFolder folder(Path());
    EXPECT_EQ(folder.LatestAbout(), "mark 2");
    ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
    ASSERT_EQ(folder.Read().first.marks.size(), 1u);
    EXPECT_EQ(folder.Read().first.marks[0].mark, "1");
  }
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\n4711,1,6,7,1\n");
  MeasurementFolder folder(Path());
  EXPECT_EQ(folder.LatestAbout(), "");
  EXPECT_EQ(Undo(&folder), EntryOutcome::kNothing);
  EXPECT_EQ(folder.Read().first.marks.size(), 1u);
}

TEST_F(MeasurementFolderTest, AHistoryThatIsDamagedOrNoTextCostsNoWord) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/.orient-review.undo.json", "{\"words\": [{\"about\": 3");
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark,col,row,sigma\nfoto\xfc,1,6,7,1\n");
  MeasurementFolder folder(Path());
  EXPECT_EQ(folder.LatestAbout(), "");
  ASSERT_EQ(Record(&folder, MarkEntry("1", 5)), EntryOutcome::kRecorded);
  Entry withdrawn;
  withdrawn.no_marks = {{"foto\xfc", "1"}};
  ASSERT_EQ(Record(&folder, withdrawn), EntryOutcome::kRecorded)
      << "the line with no UTF-8 is in the history";
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_EQ(folder.Read().first.marks.size(), 2u);
}

// Any sequence of words and of reviews, taken back to its beginning.
TEST_F(MeasurementFolderTest, UndoneToTheEndTheFilesAreAsTheyWereInTheBeginning) {
  fs::create_directory(Path());
  const std::string begin = "# by hand\nphoto,mark,col,row,sigma\n4711,9,6,7,1\n4712,1,6,7,1\n";
  WriteFileAtomically(Path() + "/marks.csv", begin);
  std::mt19937 random(5);
  int entries = 0;
  for (int review = 0; review < 8; ++review) {
    MeasurementFolder folder(Path());
    for (int action = 0; action < 6; ++action) {
      const int what = static_cast<int>(random() % 4);
      if (what == 0 && entries > 0) {
        ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
        --entries;
        continue;
      }
      const std::string mark = std::to_string(random() % 5);
      Entry entry =
          what == 1 ? DecisionEntry(DecisionKind::kReject) : MarkEntry(mark, double(action));
      if (what == 2) entry.no_marks = {{"4711", "9"}};
      ASSERT_EQ(Record(&folder, entry), EntryOutcome::kRecorded);
      ++entries;
    }
  }
  ASSERT_GT(entries, 10);
  MeasurementFolder folder(Path());
  for (; entries > 0; --entries) ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_EQ(Undo(&folder), EntryOutcome::kNothing);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), begin);
  EXPECT_FALSE(fs::exists(Path() + "/decisions.csv"));
}

TEST_F(MeasurementFolderTest, CoordinatesAreWithdrawnApartFromThePlaceInThePhoto) {
  MeasurementFolder folder(Path());
  Entry point;
  point.points = {{"p", {1, 2, 3}, {1, 1, 1}, PointRole::kControl, {}},
                  {"q", {1, 2, 3}, {1, 1, 1}, PointRole::kCheck, {}}};
  point.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  Record(&folder, point);
  Entry withdrawn;
  withdrawn.no_points = {"p"};
  ASSERT_EQ(Record(&folder, withdrawn), EntryOutcome::kRecorded);
  const Measurements now = folder.Read().first;
  EXPECT_EQ(now.Point("p"), nullptr);
  EXPECT_NE(now.Point("q"), nullptr);
  EXPECT_EQ(now.image_points.size(), 1u);
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_NE(folder.Read().first.Point("p"), nullptr);
}

TEST_F(MeasurementFolderTest, WhatIsWithdrawnIsNotSaidAnyMore) {
  MeasurementFolder folder(Path());
  Record(&folder, MarkEntry("1", 5));
  Record(&folder, DecisionEntry(DecisionKind::kAccept));
  Entry withdrawn;
  withdrawn.no_marks = {{"4711", "1"}};
  withdrawn.no_decisions = {{"4711", DecisionKind::kAccept}};
  ASSERT_EQ(Record(&folder, withdrawn), EntryOutcome::kRecorded);
  const Measurements read = ReadMeasurements(Path());
  EXPECT_TRUE(read.marks.empty());
  EXPECT_TRUE(read.decisions.empty());
}

TEST_F(MeasurementFolderTest, KeepsACopyOfAFileThatAPersonHadWritten) {
  fs::create_directory(Path());
  const std::string theirs = "# from the field book\nphoto,mark,col,row,sigma\n4711,1,6,7,1\n";
  WriteFileAtomically(Path() + "/marks.csv", theirs);
  MeasurementFolder folder(Path());
  Record(&folder, MarkEntry("2", 5));
  Record(&folder, MarkEntry("3", 5));
  EXPECT_EQ(ReadFile(Path() + "/marks.csv.before_review"), theirs);
  Undo(&folder);
  ASSERT_EQ(Undo(&folder), EntryOutcome::kRecorded);
  EXPECT_EQ(ReadFile(Path() + "/marks.csv"), theirs);
}

TEST_F(MeasurementFolderTest, WhatTheFilesCannotHoldIsRefusedAndNotWritten) {
  MeasurementFolder folder(Path());
  const auto refused = [&](const Entry& entry, std::initializer_list<std::string> parts) {
    ExpectError<InputError>([&] { Record(&folder, entry); }, parts);
  };
  refused(MarkEntry("", 5), {"the mark has no name"});
  refused(MarkEntry(" 1", 5), {"blanks around"});
  refused(MarkEntry("1\n2", 5), {"line breaks"});
  refused(MarkEntry(std::string(201, 'x'), 5), {"more than 200"});
  refused(MarkEntry("1", std::numeric_limits<double>::quiet_NaN()), {"pixel", "number"});
  refused(MarkEntry("1", 1e12), {"pixel"});
  refused(DecisionEntry(DecisionKind::kOrientation, "r91"), {"r91", "must be r0"});
  refused(DecisionEntry(DecisionKind::kPixelSize, "-3"), {"-3"});
  Entry no_sigma = MarkEntry("1", 5);
  no_sigma.marks[0].sigma_px = 0;
  refused(no_sigma, {"sigma is 0"});
  no_sigma.marks[0].sigma_px = 1e-10;  // the files' readers would refuse it
  refused(no_sigma, {"sigma is 1e-10"});
  EXPECT_TRUE(fs::is_empty(Path()) || !fs::exists(Path() + "/marks.csv"));
  EXPECT_FALSE(fs::exists(Path() + "/decisions.csv"));
}

TEST_F(MeasurementFolderTest, NamesThatLookLikeMarkupOrFormulasComeBackAsTheyWere) {
  MeasurementFolder folder(Path());
  for (const std::string name : {"<b>1</b>", "=1+1", "a,\"b\"", "#1", "\xC3\xA4"}) {
    ASSERT_EQ(Record(&folder, MarkEntry(name, 5)), EntryOutcome::kRecorded) << name;
    EXPECT_EQ(folder.Read().first.marks.back().mark, name);
  }
}

TEST_F(MeasurementFolderTest, ClicksDoNotMixWithPointsOfThePhotoSystem) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/image_points.csv", "photo,point,x_mm,y_mm,sigma\na,p,1,2,1\n");
  MeasurementFolder folder(Path());
  Entry entry;
  entry.image_points = {{"4711", "p", Eigen::Vector2d(3, 4), std::nullopt, 1, {}}};
  ExpectError<InputError>([&] { Record(&folder, entry); }, {"image_points.csv", "--measurements"});
}

TEST_F(MeasurementFolderTest, TwoReviewsDoNotShareAFolder) {
  const MeasurementFolder folder(Path());
  ExpectError<InputError>([&] { MeasurementFolder again(Path()); }, {Path()});
}

TEST_F(MeasurementFolderTest, AWrongFileIsToldWhenTheReviewBegins) {
  fs::create_directory(Path());
  WriteFileAtomically(Path() + "/marks.csv", "photo,mark\n");
  ExpectError<InputError>([&] { MeasurementFolder folder(Path()); }, {"marks.csv, line 1"});
}

}  // namespace
}  // namespace orient
