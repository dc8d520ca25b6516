#include "block/stages/exterior_learning.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

// Two photos, of which each sought the patches 1 to 4 and saw nothing of 5.
class LearningOfARun : public testing::Test {
 protected:
  LearningOfARun() {
    MadeUpDatabase(patchdb_, 5, 5);
    for (const std::string name : {"a", "b"}) {
      photos_.push_back(folder_ / (name + ".tif"));
      WriteFileAtomically(photos_.back(), "scan " + name);
      ExteriorResult result;
      result.photo = name;
      result.status = Status::kOk;
      result.pose.emplace();
      result.covariance = Matrix6d::Identity();
      for (int id = 1; id <= 5; ++id) {
        PatchResult patch;
        patch.id = id;
        patch.state = id < 4    ? PatchState::kMatched
                      : id == 4 ? PatchState::kNotFound
                                : PatchState::kNotVisible;
        result.patches.push_back(patch);
      }
      results_.push_back(result);
    }
  }

  void Run(const std::vector<char>& fresh, bool resume) {
    Learning learning(patchdb_, folder_.Path(), resume);
    learning.Tell(photos_, dates_, fresh, &results_);
  }
  std::string DatesOfAttempts() const {
    return SQLite::Database(patchdb_, SQLite::OPEN_READONLY)
        .execAndGet("SELECT group_concat(DISTINCT photo_date) FROM attempts")
        .getString();
  }
  std::int64_t Attempts() const {
    return patchdb::PatchDatabase::Open(patchdb_, patchdb::PatchDatabase::Mode::kRead)
        .Info()
        .attempts;
  }
  // A run that is killed before it tells anything.
  void BeKilled(bool resume) { const Learning learning(patchdb_, folder_.Path(), resume); }
  bool NoteIsThere() const { return std::filesystem::exists(folder_ / "not_yet_learnt"); }

  const TemporaryFolder folder_;
  const std::string patchdb_ = folder_ / "patches.gpkg";
  std::vector<std::string> photos_;
  std::vector<std::optional<std::string>> dates_ = {std::nullopt, std::nullopt};
  std::vector<ExteriorResult> results_;
};

TEST_F(LearningOfARun, TellsOfEveryPatchThatWasSoughtAndNotOfThoseOutOfSight) {
  Run({1, 1}, false);
  EXPECT_EQ(Attempts(), 8);
  for (const ExteriorResult& result : results_) EXPECT_TRUE(result.findings.empty());
}

TEST_F(LearningOfARun, TellsWhenThePhotosWereTaken) {
  dates_ = {"1961", "1998-07-30"};
  Run({1, 1}, false);
  EXPECT_EQ(DatesOfAttempts(), "1961,1998-07-30");
}

TEST_F(LearningOfARun, ResultsThatWereKeptAreNotToldAgain) {
  Run({0, 1}, true);
  EXPECT_EQ(Attempts(), 4);
}

TEST_F(LearningOfARun, WhatAnInterruptedRunFoundIsToldByTheOneThatGoesOn) {
  BeKilled(false);
  EXPECT_TRUE(NoteIsThere());
  EXPECT_EQ(Attempts(), 0);
  Run({0, 1}, true);
  EXPECT_EQ(Attempts(), 8);
  EXPECT_FALSE(NoteIsThere());
}

TEST_F(LearningOfARun, IsOwedThroughSeveralInterruptions) {
  BeKilled(false);
  BeKilled(true);
  Run({0, 0}, true);
  EXPECT_EQ(Attempts(), 8);
}

TEST_F(LearningOfARun, OnceToldNothingIsOwed) {
  BeKilled(false);
  Run({1, 1}, true);
  results_[0].photo = "another";
  Run({0, 0}, true);
  EXPECT_EQ(Attempts(), 8);
}

// A run that does not go on makes its results anew: what is kept in it is none.
TEST_F(LearningOfARun, ARunThatDoesNotGoOnOwesNothingOfAnEarlierOne) {
  BeKilled(false);
  Run({0, 1}, false);
  EXPECT_EQ(Attempts(), 4);
}

TEST_F(LearningOfARun, WhatCannotBeToldIsSaidAndThePhotoStaysOk) {
  Learning learning(patchdb_, folder_.Path(), false);
  results_[1].patches.clear();
  SQLite::Database(patchdb_, SQLite::OPEN_READWRITE).exec("DROP TABLE attempts");
  learning.Tell(photos_, dates_, {1, 1}, &results_);
  ASSERT_EQ(results_[0].findings.size(), 1u);
  EXPECT_EQ(results_[0].findings[0].reason, Reason::kNotLearnt);
  EXPECT_NE(results_[0].findings[0].where.find("patches.gpkg"), std::string::npos);
  EXPECT_EQ(results_[0].status, Status::kOk);
  EXPECT_EQ(StatusOf(results_[0].findings), Status::kOk);
  const ExteriorResult written =
      ReadExteriorResult(ExteriorResultPath(folder_.Path(), results_[0].photo));
  EXPECT_EQ(written.findings, results_[0].findings);
  EXPECT_TRUE(results_[1].findings.empty()) << "there was nothing to tell of it";
  EXPECT_FALSE(std::filesystem::exists(ExteriorResultPath(folder_.Path(), "b")));
}

TEST_F(LearningOfARun, WhatCouldNotBeToldIsToldByALaterRun) {
  {
    Learning learning(patchdb_, folder_.Path(), false);
    SQLite::Database raw(patchdb_, SQLite::OPEN_READWRITE);
    raw.exec("ALTER TABLE attempts RENAME TO hidden");
    learning.Tell(photos_, dates_, {1, 1}, &results_);
    raw.exec("ALTER TABLE hidden RENAME TO attempts");
  }
  EXPECT_TRUE(NoteIsThere());
  ASSERT_EQ(results_[0].findings.size(), 1u);
  Run({0, 0}, true);
  EXPECT_FALSE(NoteIsThere());
  EXPECT_EQ(Attempts(), 8);
  EXPECT_TRUE(results_[0].findings.empty());
  EXPECT_TRUE(
      ReadExteriorResult(ExteriorResultPath(folder_.Path(), results_[0].photo)).findings.empty());
}

TEST_F(LearningOfARun, APhotoThatSoughtNothingTeachesNothing) {
  results_[0].patches.clear();
  Run({1, 1}, false);
  EXPECT_EQ(Attempts(), 4);
  EXPECT_TRUE(results_[0].findings.empty());
}

TEST_F(LearningOfARun, APhotoWhoseScanIsGoneTeachesNevertheless) {
  std::filesystem::remove(photos_[0]);
  Run({1, 1}, false);
  EXPECT_EQ(Attempts(), 8);
}

TEST_F(LearningOfARun, ADatabaseThatIsNotThereStopsTheRunBeforeItBegins) {
  ExpectError<InputError>([&] { Learning(folder_ / "none.gpkg", folder_.Path(), false); },
                          {"none.gpkg", "--learn"});
  EXPECT_FALSE(NoteIsThere()) << "no run was begun";
}

}  // namespace
}  // namespace orient::block
