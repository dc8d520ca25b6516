// What a database makes of the attempts that photos report.
#include "patchdb/store/learn.h"

#include <gtest/gtest.h>

#include "patchdb/maintenance/life.h"
#include "patchdb/store/content_digest.h"
#include "patchdb/store/learning.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

class LearnTest : public testing::Test {
 protected:
  // Patch 13 in the middle of 25 fails, the others match.
  void Seek(const std::string& photo, const std::string& status = "ok", bool neighbours = true,
            const std::string& digest = "") {
    std::vector<MatchAttempt> attempts;
    for (int id = 1; id <= 25; ++id) {
      attempts.push_back(MadeUpAttempt(id, photo, neighbours && id != 13, status));
      attempts.back().photo_digest = digest;
    }
    database_.RecordAttempts(attempts);
  }
  Patch Middle() { return *database_.ReadPatch(13); }

  TemporaryFolder folder_;
  PatchDatabase database_ = MadeUpDatabase(folder_ / "patches.gpkg", 5, 5);
};

TEST_F(LearnTest, AttemptsMoveTheBelief) {
  Seek("a");
  EXPECT_EQ(Middle().failure_weight, 1);
  EXPECT_EQ(database_.ReadPatch(1)->success_weight, 1);
  EXPECT_LT(BeliefOf(Middle()).Mean(), 0.75);
  EXPECT_GT(BeliefOf(*database_.ReadPatch(1)).Mean(), 0.75);
}

TEST_F(LearnTest, TheSamePhotoAgainIsOneWitness) {
  for (int i = 0; i < 4; ++i) Seek("a");
  EXPECT_EQ(Middle().failure_weight, 1);
  EXPECT_EQ(Middle().life, PatchLife::kActive);
}

TEST_F(LearnTest, ThirdPhotoRetiresAndRestoreBringsBackForGood) {
  Seek("a");
  Seek("b");
  EXPECT_EQ(Middle().life, PatchLife::kActive);
  const std::string content = ContentOf(database_);
  Seek("c");
  EXPECT_EQ(Middle().life, PatchLife::kRetired);
  EXPECT_EQ(ContentOf(database_), content) << "photos that taught are not old for it";
  EXPECT_NE(Middle().retired_reason.find("3 photos"), std::string::npos);
  EXPECT_EQ(database_.Info().retired, 1);

  EXPECT_EQ(RestorePatches(database_, {13}), 1);
  EXPECT_EQ(Middle().life, PatchLife::kActive);
  EXPECT_EQ(Middle().epoch, 2);
  EXPECT_EQ(Middle().failure_weight, 0.75);
  Seek("d");
  Seek("e");
  EXPECT_EQ(Middle().life, PatchLife::kActive) << "a new epoch begins to count anew";
  Seek("f");
  EXPECT_EQ(Middle().life, PatchLife::kRetired);
}

TEST_F(LearnTest, OneImageUnderThreeNamesIsOneWitness) {
  for (const char* photo : {"a", "b", "c"}) Seek(photo, "ok", true, "0123");
  EXPECT_EQ(Middle().life, PatchLife::kActive);
  EXPECT_EQ(Middle().failure_weight, 1);
  Seek("d", "ok", true, "4567");
  Seek("e", "ok", true, "89ab");
  EXPECT_EQ(Middle().life, PatchLife::kRetired) << "three images";
}

TEST_F(LearnTest, FailedPhotosAndFailingNeighboursRetireNobody) {
  for (const char* photo : {"a", "b", "c", "d"}) Seek(photo, "failed", false);
  for (const char* photo : {"e", "f", "g", "h"}) Seek(photo, "ok", false);
  EXPECT_EQ(database_.Info().retired, 0);
  EXPECT_EQ(Middle().failure_weight, 4);
}

TEST_F(LearnTest, AttemptsOfPatchesThatHadTheseNumbersBeforeAreLeftOut) {
  const Eigen::Vector2d place_m = database_.ReadPatch(1)->ground_m.head<2>();
  MatchAttempt here = MadeUpAttempt(1, "a", true), elsewhere = MadeUpAttempt(1, "b", true);
  here.place_m = place_m + Eigen::Vector2d(0.5, -0.5);  // the index of places rounds
  elsewhere.place_m = place_m + Eigen::Vector2d(0, 100);
  EXPECT_EQ(database_.RecordAttempts({here, elsewhere, MadeUpAttempt(999, "a", true)}), 1);
  EXPECT_EQ(database_.Info().attempts, 1);
  EXPECT_EQ(database_.ReadPatch(1)->success_weight, 1);
}

TEST_F(LearnTest, PatchesPrunedMeanwhileAreLeftOut) {
  database_.RecordAttempts({MadeUpAttempt(999, "a", true), MadeUpAttempt(1, "a", true)});
  EXPECT_EQ(database_.Info().attempts, 1);
  EXPECT_EQ(database_.ReadPatch(1)->success_weight, 1);
}

TEST_F(LearnTest, PhotosOfOneNameAreToldApartByTheirContent) {
  MatchAttempt attempt = MadeUpAttempt(1, "4711", true);
  database_.RecordAttempts({attempt});
  attempt.photo_digest = "0123";
  database_.RecordAttempts({attempt});
  EXPECT_EQ(database_.Info().attempts, 1) << "one of unknown content was this one";
  attempt.photo_digest = "4567";
  for (int time = 0; time < 2; ++time) database_.RecordAttempts({attempt});
  EXPECT_EQ(database_.Info().attempts, 2);
  EXPECT_EQ(database_.ReadPatch(1)->success_weight, 2);
}

}  // namespace
}  // namespace orient::patchdb
