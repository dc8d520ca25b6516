#include <gmock/gmock.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <set>

#include "patchdb/regions/control_patches.h"
#include "tests/patchdb/regions/regions_fixture.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

TEST_F(RegionsTest, AttemptsReachThePatchesOfTheirRegions) {
  Divide();
  std::vector<MatchAttempt> attempts;
  for (const Patch& patch : ControlPatches::Open(regions_).FindPatchesIn(kAll)) {
    attempts.push_back({patch.id, "0815", "matched", 0.9, {}, ""});
    attempts.back().photo_digest = "d";
  }
  const auto count = [&] {
    std::int64_t sum = 0;
    for (const std::string& file : RegionFiles(regions_, ReadRegionIndex(regions_)))
      sum += PatchDatabase::Open(file, PatchDatabase::Mode::kRead).Info().attempts;
    return sum;
  };
  ControlPatches::Open(regions_, ControlPatches::Mode::kWrite).RecordAttempts(attempts);
  EXPECT_EQ(count(), 100);
  ControlPatches again = ControlPatches::Open(regions_, ControlPatches::Mode::kWrite);
  again.RecordAttempts(attempts);
  again.RequireCurrentIndex();
  EXPECT_EQ(count(), 100);
  const auto taught = again.ReadPatch(attempts.back().patch_id);
  ASSERT_TRUE(taught);
  EXPECT_GT(taught->success_weight, 0);
}

// What the single database would have learnt: neighbours beyond a region's border count.
TEST_F(RegionsTest, LearnAsTheWholeDatabaseDoes) {
  PatchDatabase whole = Filled(120);
  DivideDatabase(whole, regions_, 3400);
  const auto attempts_in = [](const std::vector<Patch>& patches) {
    std::vector<MatchAttempt> attempts;
    for (const Patch& patch : patches)
      for (const char* photo : {"a", "b", "c"}) {
        const bool matched = std::fmod(patch.ground_m.x() + patch.ground_m.y(), 7) > 1;
        attempts.push_back({patch.id, photo, matched ? "matched" : "not_found", {}, {}, ""});
        attempts.back().photo_status = "ok";
        attempts.back().photo_digest = photo;
        attempts.back().place_m = patch.ground_m.head<2>();
      }
    return attempts;
  };
  const auto learnt = [](const std::string& path) {
    std::multiset<std::string> rows;
    SQLite::Database raw(path, SQLite::OPEN_READONLY);
    SQLite::Statement row(raw,
                          "SELECT hex(p.geom), p.state, p.success_weight, p.failure_weight, "
                          "a.photo, a.neighbours_sought, a.neighbours_matched FROM attempts AS a "
                          "JOIN patches AS p ON p.id = a.patch_id");
    while (row.executeStep()) {
      std::string text;
      for (int i = 0; i < row.getColumnCount(); ++i) text += row.getColumn(i).getString() + " ";
      rows.insert(text);
    }
    return rows;
  };
  whole.RecordAttempts(attempts_in(whole.FindPatchesIn(kAll)));
  ControlPatches divided = ControlPatches::Open(regions_, ControlPatches::Mode::kWrite);
  divided.RecordAttempts(attempts_in(divided.FindPatchesIn(kAll)));
  std::multiset<std::string> of_regions;
  for (const std::string& file : RegionFiles(regions_, ReadRegionIndex(regions_)))
    of_regions.merge(learnt(file));
  EXPECT_EQ(of_regions.size(), 360);
  EXPECT_EQ(of_regions, learnt(path_));
  EXPECT_GT(whole.Info().retired, 0);
}

// Regions whose numbers became others' learn nothing, and what was sought elsewhere is no
// neighbour.
TEST_F(RegionsTest, LearnNothingFromPatchesThatHadTheirNumbers) {
  Divide(120, 6000);
  ControlPatches divided = ControlPatches::Open(regions_, ControlPatches::Mode::kWrite);
  const std::vector<Patch> patches = divided.FindPatchesIn(kAll);
  const auto region_of = [](std::int64_t id) { return id / 1'000'000'000; };
  const std::int64_t first = region_of(patches.front().id);
  std::vector<MatchAttempt> attempts;
  int of_others = 0;
  for (const Patch& patch : patches) {
    const bool other = region_of(patch.id) != first;
    of_others += other ? 1 : 0;
    attempts.push_back({patch.id, "a", other ? "matched" : "not_found", {}, {}, ""});
    attempts.back().place_m = patch.ground_m.head<2>() + Eigen::Vector2d(other ? 5e5 : 0, 0);
  }
  ASSERT_GT(of_others, 0);
  EXPECT_EQ(divided.RecordAttempts(attempts), of_others);
  int learnt = 0;
  for (const std::string& file : RegionFiles(regions_, ReadRegionIndex(regions_))) {
    SQLite::Database raw(file, SQLite::OPEN_READONLY);
    SQLite::Statement row(raw, "SELECT neighbours_sought, neighbours_matched FROM attempts");
    for (; row.executeStep(); ++learnt) {
      EXPECT_EQ(row.getColumn(0).getInt(), 8);
      EXPECT_EQ(row.getColumn(1).getInt(), 0);
    }
  }
  EXPECT_EQ(learnt, static_cast<int>(patches.size()) - of_others);
}

TEST_F(RegionsTest, AreToldOfAttemptsThoughOneOfThemCannotBe) {
  Divide(90);
  std::vector<MatchAttempt> attempts;
  for (const Patch& patch : ControlPatches::Open(regions_).FindPatchesIn(kAll))
    attempts.push_back({patch.id, "0815", "matched", 0.9, {}, ""});
  const std::vector<std::string> files = RegionFiles(regions_, ReadRegionIndex(regions_));
  SQLite::Database(files[3], SQLite::OPEN_READWRITE).exec("DROP TABLE attempts");
  ControlPatches patches = ControlPatches::Open(regions_, ControlPatches::Mode::kWrite);
  EXPECT_THAT(WhatIsWrong([&] { patches.RecordAttempts(attempts); }), HasSubstr(files[3]));
  for (std::size_t i = 0; i < files.size(); ++i)
    if (i != 3) {
      const auto info = PatchDatabase::Open(files[i], PatchDatabase::Mode::kRead).Info();
      EXPECT_EQ(info.attempts, info.patches) << files[i];
    }
}

TEST_F(RegionsTest, AFolderThatMayNotBeWrittenDoesNotLearn) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  Divide();
  fs::permissions(regions_, fs::perms::owner_read | fs::perms::owner_exec);
  EXPECT_THAT(WhatIsWrong([&] { ControlPatches::Open(regions_, ControlPatches::Mode::kWrite); }),
              HasSubstr("may not be written"));
  EXPECT_EQ(ControlPatches::Open(regions_).FindPatchesIn(kAll).size(), 100);
  fs::permissions(regions_, fs::perms::owner_all);
}

}  // namespace
}  // namespace orient::patchdb
