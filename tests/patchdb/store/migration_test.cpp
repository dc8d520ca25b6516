// A file of every older schema is brought up to today's by the first command that writes, and
// nothing is lost on the way.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/error.h"
#include "patchdb/maintenance/check.h"
#include "patchdb/store/content_digest.h"
#include "patchdb/store/geopackage_geometry.h"
#include "patchdb/store/older_file.h"
#include "patchdb/store/patch_blobs.h"
#include "patchdb/store/patch_database.h"
#include "patchdb/store/schema.h"
#include "tests/patchdb/store/valid_geopackage.h"
#include "tests/support/older_patchdb.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

using Mode = PatchDatabase::Mode;

void BindBlob(SQLite::Statement& statement, int index, const Bytes& bytes) {
  statement.bind(index, static_cast<const void*>(bytes.data()), static_cast<int>(bytes.size()));
}

// What Orient wrote in the days of schema version 1: patches 1 and 3 of a photo, an attempt each.
void WriteVersion1(const std::string& path) {
  SQLite::Database file(path, SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  RegisterSpatialFunctions(file.getHandle());
  file.exec("PRAGMA application_id = " + std::to_string(kGeoPackageApplicationId));
  file.exec("PRAGMA user_version = " + std::to_string(kGeoPackageVersion));
  file.exec(kSchemaStep1.sql);
  file.exec("INSERT INTO orient_schema VALUES (1, 'as it was')");
  SQLite::Statement crs(
      file, "INSERT INTO gpkg_spatial_ref_sys VALUES ('UTM', 32635, 'EPSG', 32635, ?1, '')");
  crs.bind(1, Crs::Parse("EPSG:32635", "test").Wkt1());
  crs.exec();
  file.exec(
      "INSERT INTO gpkg_contents (table_name, data_type, identifier, srs_id) VALUES "
      "('patches', 'features', 'patches', 32635), ('sources', 'attributes', 'sources', NULL), "
      "('attempts', 'attributes', 'attempts', NULL), "
      "('orient_schema', 'attributes', 'orient_schema', NULL)");
  file.exec("INSERT INTO gpkg_geometry_columns VALUES ('patches', 'geom', 'POINT', 32635, 1, 0)");
  file.exec("INSERT INTO sources VALUES (7, 'photo', '4711.tif', '1961', 0.5)");
  for (const int id : {1, 3}) {
    SQLite::Statement insert(
        file,
        "INSERT INTO patches (id, geom, source_id, gsd_m, bits, chip, heights, "
        "heights_size, heights_step_m, covariance, distinctness) VALUES "
        "(?1, ?2, 7, 0.5, 8, ?3, ?4, 3, 6, ?5, 0.5)");
    insert.bind(1, id);
    BindBlob(insert, 2, EncodePointZ({500000.0 + id, 5000000.5, 123}, 32635));
    BindBlob(insert, 3, EncodeChip(Image(21, 21, static_cast<float>(id)), 8));
    BindBlob(insert, 4, EncodeHeights({3, 6, {1, 2, 3, 4, 5, 6, 7, 8, 9}}));
    BindBlob(insert, 5, EncodeCovariance(Eigen::Matrix3d::Identity()));
    insert.exec();
  }
  file.exec(
      "INSERT INTO attempts (patch_id, photo, state, reason) VALUES (1, 'a', 'matched', ''), "
      "(3, 'a', 'not_found', 'no peak')");
}

class MigrationTest : public testing::Test {
 protected:
  void SetUp() override { WriteVersion1(path_); }
  TemporaryFolder folder_;
  std::string path_ = folder_ / "old.gpkg";
};

TEST_F(MigrationTest, ReadingAnOldFileSaysHowItComesUpToDate) {
  try {
    PatchDatabase::Open(path_, Mode::kRead);
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("version 1"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("check FILE --repair"), std::string::npos)
        << error.what();
  }
}

TEST_F(MigrationTest, ReadingAFileOfVersion3TakesItAsItIs) {
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    CheckOptions options;
    options.repair = true;  // version 1 had no weights of its attempts
    CheckDatabase(database, options);
  }
  MakeVersion3(path_);
  EXPECT_EQ(OlderVersion(path_), 3);
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
    EXPECT_EQ(database.Info().schema_version, 3);
    EXPECT_EQ(database.FindPatchesIn({500000, 5000000, 500010, 5000010}).size(), 2u);
    EXPECT_TRUE(CheckDatabase(database, {}).empty());
    EXPECT_NE(ContentOf(database), ContentOf(database));  // nobody notes that it changes
  }
  EXPECT_EQ(OlderVersion(path_), 3);
  PatchDatabase::Open(path_, Mode::kWrite);
  EXPECT_EQ(OlderVersion(path_), std::nullopt);
  EXPECT_EQ(OlderVersion(folder_ / "none.gpkg"), std::nullopt);
}

TEST_F(MigrationTest, WritingBringsItUpToDateAndLosesNothing) {
  PatchDatabase::Open(path_, Mode::kWrite);
  const PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  const PatchDatabaseInfo info = database.Info();
  EXPECT_EQ(info.schema_version, CurrentSchemaVersion());
  EXPECT_EQ(info.patches, 2);
  EXPECT_EQ(info.attempts, 2);
  const auto patches = database.FindPatchesIn({500000, 5000000, 500010, 5000010});
  ASSERT_EQ(patches.size(), 2u);
  EXPECT_EQ(patches[1].id, 3);
  EXPECT_EQ(patches[1].source_id, 7);
  EXPECT_EQ(patches[1].chip.At(5, 5), 3);
  EXPECT_EQ(patches[1].heights.heights_m, (std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8, 9}));
  EXPECT_EQ(patches[1].distinctness, 0.5);
  EXPECT_FALSE(patches[1].quality);
  EXPECT_FALSE(patches[1].created);
  ASSERT_EQ(database.Sources().size(), 1u);
  EXPECT_EQ(database.Sources()[0].date, "1961");
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  EXPECT_EQ(raw.execAndGet("PRAGMA integrity_check").getString(), "ok");
  EXPECT_EQ(raw.execAndGet("SELECT rtreecheck('rtree_patches_geom')").getString(), "ok");
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM pragma_foreign_key_check").getInt(), 0);
}

TEST_F(MigrationTest, NewRowsFollowTheOldOnes) {
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
  Patch patch = database.ListPatches(0, 1)[0];
  PatchSource source{0, SourceKind::kGcp, "points.csv", {}, 0.5, {}, {}, {}};
  std::vector<Patch> patches = {patch};
  database.AddSource(source, patches);
  EXPECT_EQ(source.id, 8);
  EXPECT_EQ(patches[0].id, 4);
  EXPECT_EQ(database.FindPatchesIn({500000, 5000000, 500010, 5000010}).size(), 3u);
}

TEST_F(MigrationTest, HasTheTablesOfANewFile) {
  const auto tables = [](const std::string& path) {
    SQLite::Database raw(path, SQLite::OPEN_READONLY);
    std::string text;
    SQLite::Statement rows(raw,
                           "SELECT name, sql FROM sqlite_master WHERE sql NOT NULL ORDER BY name");
    while (rows.executeStep()) text += rows.getColumn(1).getString() + "\n";
    return text;
  };
  PatchDatabase::Open(path_, Mode::kWrite);
  PatchDatabase::Create(folder_ / "new.gpkg", Crs::Parse("EPSG:32635", "test"));
  EXPECT_EQ(tables(path_), tables(folder_ / "new.gpkg"));
}

// QGIS makes the table where somebody saves a style with the layer.
TEST_F(MigrationTest, AStyleThatSomebodyGaveThePatchesStays) {
  {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec(
        "CREATE TABLE layer_styles (id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, f_table_catalog "
        "VARCHAR(256), f_table_schema VARCHAR(256), f_table_name VARCHAR(256), f_geometry_column "
        "VARCHAR(256), styleName VARCHAR(30), styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, "
        "description TEXT, owner VARCHAR(30), ui VARCHAR(30), update_time TIMESTAMP DEFAULT "
        "CURRENT_TIMESTAMP)");
    raw.exec("INSERT INTO layer_styles (f_table_name, styleQML) VALUES ('patches', 'mine')");
  }
  PatchDatabase::Open(path_, Mode::kWrite);
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  EXPECT_EQ(raw.execAndGet("SELECT group_concat(styleQML) FROM layer_styles").getString(), "mine");
}

TEST_F(MigrationTest, RowsThatNameWhatIsNotThereAreLeftToARepair) {
  {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec("UPDATE attempts SET patch_id = 99 WHERE id = 1");
  }
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
  EXPECT_EQ(database.Info().schema_version, CurrentSchemaVersion());
  CheckOptions options;
  EXPECT_FALSE(CheckDatabase(database, options).empty());
  options.repair = true;
  CheckDatabase(database, options);
  EXPECT_TRUE(CheckDatabase(database, {}).empty());
  EXPECT_EQ(database.Info().patches, 2);
}

TEST_F(MigrationTest, IsAValidGeoPackageAfterwards) {
  PatchDatabase::Open(path_, Mode::kWrite);
  ExpectValidGeoPackage(path_);
}

}  // namespace
}  // namespace orient::patchdb
