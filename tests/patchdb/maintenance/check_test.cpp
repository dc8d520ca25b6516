#include "patchdb/maintenance/check.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/error.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/store/geopackage_geometry.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

using Mode = PatchDatabase::Mode;

class CheckTest : public testing::Test {
 protected:
  CheckTest() {
    PatchDatabase database = MadeUpDatabase(path_, 4, 3);
    database.RecordAttempts({MadeUpAttempt(1, "a", true), MadeUpAttempt(2, "a", false)});
  }
  void Damage(const std::string& sql) {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    RegisterSpatialFunctions(raw.getHandle());
    raw.exec("PRAGMA foreign_keys = OFF");
    raw.exec("PRAGMA ignore_check_constraints = ON");
    raw.exec(sql);
  }
  std::vector<CheckFinding> Look(bool repair) {
    PatchDatabase database = PatchDatabase::Open(path_, repair ? Mode::kWrite : Mode::kRead);
    CheckOptions options;
    options.repair = repair;
    return CheckDatabase(database, options);
  }
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
};

TEST_F(CheckTest, WholeDatabaseHasNoFindings) { EXPECT_TRUE(Look(false).empty()); }

TEST_F(CheckTest, WhatTheFileSaysOfItselfIsWrittenAgain) {
  const auto count = [&](const std::string& table) {
    return SQLite::Database(path_, SQLite::OPEN_READONLY)
        .execAndGet("SELECT count(*) FROM " + table)
        .getInt();
  };
  for (const std::string table : {"layer_styles", "gpkg_metadata_reference", "gpkg_metadata"}) {
    Damage("DROP TABLE " + table);
    ASSERT_EQ(Look(false).size(), 1u) << table;
    EXPECT_FALSE(Look(false)[0].repair.empty()) << table;
    Look(true);
    EXPECT_TRUE(Look(false).empty()) << table;
    for (const char* one : {"layer_styles", "gpkg_metadata"}) EXPECT_EQ(count(one), 1) << table;
  }
}

TEST_F(CheckTest, AStrangersViewsAndTriggersAreNamed) {
  Damage("CREATE VIEW spare AS SELECT 1");
  Damage("CREATE TRIGGER surprise AFTER DELETE ON attempts BEGIN DELETE FROM sources; END");
  std::string found;
  for (const CheckFinding& finding : Look(false)) found += finding.what + "\n";
  EXPECT_NE(found.find("view spare"), std::string::npos) << found;
  EXPECT_NE(found.find("trigger surprise"), std::string::npos) << found;
}

TEST_F(CheckTest, EveryDamageIsFoundRepairedAndNoPatchIsLost) {
  const char* circle =
      "UPDATE patches SET state = 'retired', retired_reason = 'x', superseded_by = id % 3 + 1 "
      "WHERE id <= 3";
  const char* damages[] = {
      "DELETE FROM sources",
      "UPDATE attempts SET patch_id = 99 WHERE patch_id = 1",
      "INSERT INTO evidence (patch_id, source_id) VALUES (99, 1)",
      "UPDATE patches SET superseded_by = 99, state = 'retired', retired_reason = 'x' WHERE id = 3",
      "UPDATE patches SET superseded_by = 3 WHERE id = 3",
      circle,
      "UPDATE patches SET state = 'retired' WHERE id = 3",
      "UPDATE patches SET views = 7 WHERE id = 3",
      "DELETE FROM rtree_patches_geom WHERE id = 3",
      "UPDATE rtree_patches_geom SET minx = 1, maxx = 2 WHERE id = 3",
      "INSERT INTO rtree_patches_geom VALUES (77, 1, 1, 2, 2)",
      "UPDATE gpkg_contents SET max_x = min_x WHERE table_name = 'patches'",
      "UPDATE patches SET chip = x'00' WHERE id = 3",
      "UPDATE patches SET heights = x'00' WHERE id = 3",
      "UPDATE patches SET covariance = 'text' WHERE id = 3",
      "UPDATE patches SET geom = x'00' WHERE id = 3",
      "UPDATE patches SET gsd_m = -1 WHERE id = 3",
      "UPDATE patches SET failure_weight = 5 WHERE id = 1",
      "DROP TABLE orient_content",
      "DELETE FROM orient_content",
      "DROP TRIGGER orient_content_update",
      "DROP TRIGGER orient_content_delete; CREATE TRIGGER orient_content_delete AFTER DELETE ON "
      "patches BEGIN SELECT 1; END",
      "DROP TRIGGER rtree_patches_geom_insert",
      "DROP TABLE rtree_patches_geom",
      "DROP INDEX patches_by_source",
      "DROP TABLE sources",
      "DROP TABLE evidence"};
  for (const char* damage : damages) {
    const std::string whole = path_ + ".whole";
    std::filesystem::copy_file(path_, whole);
    Damage(damage);
    EXPECT_FALSE(Look(false).empty()) << damage;
    EXPECT_FALSE(Look(true).empty()) << damage;
    for (const CheckFinding& finding : Look(false)) ADD_FAILURE() << damage << ": " << finding.what;
    EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 12) << damage;
    std::filesystem::rename(whole, path_);
  }
}

TEST_F(CheckTest, WhatTheFileSaysOfItselfIsMissedAndNotMadeUp) {
  Damage("DROP TABLE gpkg_extensions");
  for (const bool repair : {false, true}) {
    const auto findings = Look(repair);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_NE(findings[0].what.find("gpkg_extensions"), std::string::npos) << findings[0].what;
    EXPECT_EQ(findings[0].repair, "");
  }
}

// A change that nobody noted may have happened meanwhile.
TEST_F(CheckTest, RepairOfTheTokensTriggersRenewsIt) {
  const auto token = [&] {
    SQLite::Database raw(path_, SQLite::OPEN_READONLY);
    return raw.execAndGet("SELECT hex(token) FROM orient_content").getString();
  };
  const std::string before = token();
  Look(true);
  EXPECT_EQ(token(), before);
  Damage("DROP TRIGGER orient_content_state");
  const auto findings = Look(true);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_NE(findings[0].what.find("orient_content_state"), std::string::npos) << findings[0].what;
  EXPECT_NE(token(), before);
}

// As GDAL keeps a spatial index of that version.
TEST_F(CheckTest, TriggersOfGeoPackage14AreTakenForThoseThatTheyReplace) {
  Damage(
      "DROP TRIGGER rtree_patches_geom_update1; DROP TRIGGER rtree_patches_geom_update3;"
      "CREATE TRIGGER rtree_patches_geom_update6 AFTER UPDATE OF geom ON patches BEGIN SELECT 1; "
      "END");
  EXPECT_TRUE(Look(false).empty());
}

TEST_F(CheckTest, AfterRepairTheOthersAreFound) {
  Damage("UPDATE patches SET chip = x'00' WHERE id = 3");
  EXPECT_THROW(PatchDatabase::Open(path_, Mode::kRead).FindPatchesIn({0, 0, 1e7, 1e7}), InputError);
  Look(true);
  const PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(database.FindPatchesIn({0, 0, 1e7, 1e7}).size(), 11u);
}

// Chains of 3000, of which one leads into a circle of three.
TEST_F(CheckTest, LongChainsOfSuccessorsAreNoCircles) {
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    PatchSource source = MadeUpSource("many.tif");
    std::vector<Patch> many(3000, MadeUpPatch(600000, 5000000, 1));
    database.AddSource(source, many);
  }
  Damage(
      "UPDATE patches SET state = 'retired', retired_reason = 'x', superseded_by = id + 1 WHERE id "
      "> 12 AND id < 3012");
  EXPECT_TRUE(Look(false).empty());
  Damage(
      "UPDATE patches SET state = 'retired', retired_reason = 'x', superseded_by = 3010 WHERE id = "
      "3012");
  const auto findings = Look(true);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].count, 3);
  EXPECT_TRUE(Look(false).empty());
}

TEST_F(CheckTest, LookingChangesNothing) {
  Damage("DELETE FROM rtree_patches_geom");
  Look(false);
  EXPECT_FALSE(Look(false).empty());
}

}  // namespace
}  // namespace orient::patchdb
