#include "patchdb/maintenance/life.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "patchdb/maintenance/statistics.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

class LifeTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
  PatchDatabase database_ = MadeUpDatabase(path_, 4, 3);
};

TEST_F(LifeTest, RetiredPatchesKeepEverythingAndComeBack) {
  EXPECT_EQ(RetirePatches(database_, {2, 3, 99}, "a roof"), 2);
  EXPECT_EQ(RetirePatches(database_, {2}, "again"), 0);
  EXPECT_EQ(database_.ReadPatch(2)->retired_reason, "a roof");
  EXPECT_EQ(database_.Info().patches, 12);
  EXPECT_EQ(RestorePatches(database_, {1, 2}), 1);
  const Patch back = *database_.ReadPatch(2);
  EXPECT_EQ(back.life, PatchLife::kActive);
  EXPECT_EQ(back.retired_reason, "");
  EXPECT_EQ(back.epoch, 2);
}

TEST_F(LifeTest, OnlyRetiredPatchesCanBeDeleted) {
  database_.RecordAttempts({MadeUpAttempt(1, "a", true), MadeUpAttempt(2, "a", true)});
  RetirePatches(database_, {2, 3}, "test");
  EXPECT_EQ(DeleteRetiredPatches(database_, {1, 2}), 1);
  EXPECT_TRUE(database_.ReadPatch(1));
  EXPECT_FALSE(database_.ReadPatch(2));
  EXPECT_TRUE(database_.ReadPatch(3));
  EXPECT_EQ(database_.Info().attempts, 1);
  EXPECT_EQ(database_.Info().patches, 11);
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM rtree_patches_geom").getInt(), 11);
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM pragma_foreign_key_check").getInt(), 0);
}

TEST_F(LifeTest, DensityCountsTheActiveOnesAndEveryCellOnce) {
  RetirePatches(database_, {1}, "test");
  const DensityGrid grid = CountDensity(database_, 200);
  EXPECT_EQ(grid.width, 2);
  EXPECT_EQ(grid.height, 2);
  EXPECT_EQ(grid.west_m, 500000);
  EXPECT_EQ(grid.north_m, 5000200);
  int sum = 0;
  for (const int count : grid.counts) sum += count;
  EXPECT_EQ(sum, 11);
  EXPECT_THROW(CountDensity(database_, 1e-3), InputError);
}

TEST_F(LifeTest, StatisticsGroupAttemptsByAgeAndMonth) {
  MatchAttempt summer = MadeUpAttempt(1, "a", true), winter = MadeUpAttempt(2, "b", false);
  summer.photo_date = "1994-07-15";
  winter.photo_date = "2015-01-02";
  MatchAttempt failed = MadeUpAttempt(3, "c", false, "failed");
  failed.photo_date = "2015-01-02";
  database_.RecordAttempts({summer, winter, failed});
  const PatchStatistics statistics = CountEverything(database_);
  ASSERT_EQ(statistics.by_age.size(), 2u);
  EXPECT_EQ(statistics.by_age[0].group, "0 years");
  EXPECT_EQ(statistics.by_age[0].matched, 1);
  EXPECT_EQ(statistics.by_age[1].group, "20 years");
  EXPECT_EQ(statistics.by_age[1].attempts, 1);
  EXPECT_EQ(statistics.by_age[1].matched, 0);
  ASSERT_EQ(statistics.by_season.size(), 2u);
  EXPECT_EQ(statistics.by_season[0].group, "01");
  ASSERT_EQ(statistics.sources.size(), 1u);
  EXPECT_EQ(statistics.sources[0].patches, 12);
}

}  // namespace
}  // namespace orient::patchdb
