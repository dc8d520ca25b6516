#include "patchdb/patch_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "core/error.h"
#include "patchdb/schema.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

namespace fs = std::filesystem;
using Mode = PatchDatabase::Mode;

Crs Utm() { return Crs::Parse("EPSG:32635", "test"); }

Patch SomePatch(double x, double y, int grey = 7) {
  Patch patch;
  patch.ground_m = {x, y, 123.5};
  patch.covariance_m2 << 1, 0.25, 0.125, 0.25, 2, 0.5, 0.125, 0.5, 3;
  patch.gsd_m = 0.5;
  patch.chip = Image(21, 21, static_cast<float>(grey));
  for (int i = 0; i < 21; ++i) patch.chip.At(i, 20 - i) = 200;
  patch.heights = {3, 6, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
  return patch;
}

PatchSource Photo(const std::string& name) {
  return {0, SourceKind::kPhoto, name, std::nullopt, 0.5, {}, {}, {}};
}

std::string WhatIsWrong(const std::function<void()>& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

class PatchDatabaseTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";

  PatchDatabase Filled(int count) {
    PatchDatabase database = PatchDatabase::Create(path_, Utm());
    PatchSource source = Photo("4711.tif");
    std::mt19937 random(TestSeed());
    std::uniform_real_distribution<double> at(0, 10000);
    std::vector<Patch> patches;
    for (int i = 0; i < count; ++i)
      patches.push_back(SomePatch(500000 + at(random), 5000000 + at(random), i % 200));
    database.AddSource(source, patches);
    return database;
  }

  void Execute(const std::string& sql) {
    SQLite::Database raw(path_, SQLite::OPEN_READWRITE);
    raw.exec(sql);
  }
};

TEST_F(PatchDatabaseTest, RoundtripOfAPatchWithEverything) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source{0, SourceKind::kOrthophoto, "ortho.tif", "1961-07-30", 0.25, {}, {}, {}};
  std::vector<Patch> patches = {SomePatch(500100.125, 5000200.25)};
  patches[0].chip.At(4, 2) = kNoData;
  patches[0].roundness = 0.75;
  patches[0].distinctness = 0.5;
  patches[0].persistence = 3;
  patches[0].relief_px = 1.5;
  patches[0].lean_px = 0.25;
  patches[0].second_peak_px = 12;
  patches[0].energy = Eigen::Vector3d(4, -1, 3);
  patches[0].quality = 0.875;
  database.AddSource(source, patches);
  EXPECT_EQ(patches[0].id, 1);
  EXPECT_EQ(patches[0].source_id, source.id);

  const auto read = PatchDatabase::Open(path_, Mode::kRead).ListPatches(0, 10);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].id, 1);
  EXPECT_EQ(read[0].source_id, source.id);
  EXPECT_EQ(read[0].ground_m, patches[0].ground_m);
  EXPECT_EQ(read[0].covariance_m2, patches[0].covariance_m2);
  EXPECT_EQ(read[0].gsd_m, 0.5);
  EXPECT_EQ(read[0].bits, 8);
  EXPECT_TRUE(std::isnan(read[0].chip.At(4, 2)));
  EXPECT_EQ(read[0].chip.At(2, 4), 7);
  EXPECT_EQ(read[0].chip.At(0, 20), 200);
  EXPECT_EQ(read[0].heights.heights_m, patches[0].heights.heights_m);
  EXPECT_EQ(read[0].heights.step_m, 6);
  EXPECT_EQ(read[0].roundness, 0.75);
  EXPECT_EQ(read[0].distinctness, 0.5);
  EXPECT_EQ(read[0].persistence, 3);
  EXPECT_EQ(read[0].relief_px, 1.5);
  EXPECT_EQ(read[0].lean_px, 0.25);
  EXPECT_EQ(read[0].second_peak_px, 12);
  EXPECT_EQ(read[0].energy, Eigen::Vector3d(4, -1, 3));
  EXPECT_EQ(read[0].quality, 0.875);
  EXPECT_EQ(read[0].life, PatchLife::kActive);
  EXPECT_EQ(read[0].epoch, 1);
  EXPECT_EQ(read[0].views, 1);
  EXPECT_TRUE(read[0].created);
  const auto sources = database.Sources();
  ASSERT_EQ(sources.size(), 1u);
  EXPECT_EQ(sources[0].kind, SourceKind::kOrthophoto);
  EXPECT_EQ(sources[0].date, "1961-07-30");
}

TEST_F(PatchDatabaseTest, RoundtripOfASource) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source{0,    SourceKind::kGcp, "points.csv",  "1961",
                     0.25, "EPSG:3067",      "survey 1961", "CC0"};
  std::vector<Patch> patches = {SomePatch(1, 2)};
  database.AddSource(source, patches);
  const auto read = database.Sources();
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].kind, SourceKind::kGcp);
  EXPECT_EQ(read[0].crs, "EPSG:3067");
  EXPECT_EQ(read[0].provenance, "survey 1961");
  EXPECT_EQ(read[0].licence, "CC0");
}

TEST_F(PatchDatabaseTest, ColourOf16BitsIsLosslessAndMatchedAsGrey) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("a");
  std::vector<Patch> patches = {SomePatch(1, 2)};
  Patch& patch = patches[0];
  patch.bits = 16;
  patch.colour = {Image(21, 21, 60000), Image(21, 21, 300), Image(21, 21, 20)};
  patch.colour[1].At(3, 4) = 65535;
  patch.chip.At(5, 6) = kNoData;
  database.AddSource(source, patches);
  const auto read = database.ReadPatch(patch.id);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->colour.size(), 3u);
  EXPECT_EQ(read->colour[0].At(0, 0), 60000);
  EXPECT_EQ(read->colour[1].At(3, 4), 65535);
  EXPECT_EQ(read->colour[2].At(20, 20), 20);
  EXPECT_TRUE(std::isnan(read->colour[1].At(5, 6)));
  EXPECT_TRUE(std::isnan(read->chip.At(5, 6)));
  EXPECT_NEAR(read->chip.At(0, 0), 0.299 * 60000 + 0.587 * 300 + 0.114 * 20, 0.01);
  const auto listed = database.ListPatches(0, 1);
  EXPECT_TRUE(listed[0].colour.empty());
  EXPECT_EQ(listed[0].chip.At(0, 0), read->chip.At(0, 0));
  EXPECT_FALSE(database.ReadPatch(99));
}

TEST_F(PatchDatabaseTest, HeightsAreKeptToA64thOfAPixelWhereverTheyLie) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("a");
  std::vector<Patch> patches = {SomePatch(1, 2), SomePatch(3, 4)};
  HeightGrid& gentle = patches[0].heights;
  gentle = {3, 6, {801.123f, 802, 803, 790.55f, kNoData, 791, 792, 793.3f, 800}};
  HeightGrid& wild = patches[1].heights;  // range too large for 16 bits
  wild = {3, 6, {0, 1, 2, 3, 4, 5, 6, 7, 8000.125f}};
  database.AddSource(source, patches);
  const auto read = database.ListPatches(0, 2);
  for (std::size_t i = 0; i < 9; ++i) {
    const float before = gentle.heights_m[i], after = read[0].heights.heights_m[i];
    EXPECT_EQ(std::isnan(before), std::isnan(after));
    if (!std::isnan(before)) {
      EXPECT_NEAR(before, after, 0.5 * 0.5 / 64 + 1e-4);
    }
  }
  EXPECT_EQ(read[1].heights.heights_m, wild.heights_m);
}

TEST_F(PatchDatabaseTest, FurtherViewsAreEvidenceAndMayMoveAPatch) {
  PatchDatabase database = Filled(3);
  Patch better = *database.ReadPatch(2);
  better.ground_m += Eigen::Vector3d(0.25, -0.5, 1);
  better.covariance_m2 *= 0.5;
  better.evidence = {{0, Eigen::Vector2d(100.5, 200.25), Eigen::Vector2d(0.125, -0.25)}};
  PatchSource second = Photo("4712.tif");
  std::vector<Patch> none;
  database.AddSource(second, none, {better});
  const auto read = database.ReadPatch(2);
  EXPECT_EQ(read->ground_m, better.ground_m);
  EXPECT_EQ(read->covariance_m2, better.covariance_m2);
  EXPECT_EQ(read->source_id, 1);
  EXPECT_EQ(read->views, 2);
  ASSERT_EQ(read->evidence.size(), 1u);
  EXPECT_EQ(read->evidence[0].source_id, second.id);
  EXPECT_EQ(read->evidence[0].pixel, Eigen::Vector2d(100.5, 200.25));
  EXPECT_EQ(read->evidence[0].residual_px, Eigen::Vector2d(0.125, -0.25));
  EXPECT_EQ(database.ReadPatch(1)->views, 1);
  const Eigen::Vector2d at = better.ground_m.head<2>();
  EXPECT_EQ(
      database.FindPatchesIn({at.x() - 1e-3, at.y() - 1e-3, at.x() + 1e-3, at.y() + 1e-3}).size(),
      1u);

  better.id = 99;
  PatchSource third = Photo("4713.tif");
  EXPECT_THROW(database.AddSource(third, none, {better}), std::invalid_argument);
  EXPECT_FALSE(database.HasSource(SourceKind::kPhoto, "4713.tif"));
}

TEST_F(PatchDatabaseTest, RetiredPatchesAreListedButNotFound) {
  Filled(5);
  Execute(
      "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; "
      "UPDATE patches SET state = 'retired', retired_reason = 'a roof' WHERE id = 4");
  const PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(database.FindPatchesIn({0, 0, 1e7, 1e7}).size(), 4u);
  EXPECT_EQ(database.Info().retired, 1);
  const auto all = database.ListPatches(0, 10);
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[3].life, PatchLife::kRetired);
  EXPECT_EQ(all[3].retired_reason, "a roof");
}

TEST_F(PatchDatabaseTest, UnknownIsNull) {
  {
    PatchDatabase database = PatchDatabase::Create(path_, Utm());
    PatchSource source = Photo("a.tif");
    std::vector<Patch> patches = {SomePatch(1, 2)};
    patches[0].heights = {};
    database.AddSource(source, patches);
    database.RecordAttempts({{patches[0].id, "b", "not_found", {}, {}, "no peak"}});
    const auto read = database.ListPatches(0, 1);
    EXPECT_FALSE(read[0].roundness || read[0].distinctness || read[0].persistence ||
                 read[0].relief_px);
    EXPECT_EQ(read[0].heights.size, 0);
    EXPECT_FALSE(database.Sources()[0].date);
  }
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM patches WHERE roundness IS NULL AND distinctness "
                           "IS NULL AND persistence IS NULL AND relief_px IS NULL AND chip_mask IS "
                           "NULL AND heights IS NULL")
                .getInt(),
            1);
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM attempts WHERE ncc IS NULL AND residual_col_px IS "
                           "NULL AND residual_row_px IS NULL")
                .getInt(),
            1);
}

// A grid of 20 columns, and a limit that keeps every 20th: not one column of it.
TEST_F(PatchDatabaseTest, OfTooManyPatchesItFindsSomeFromEverywhere) {
  constexpr int kColumns = 20, kRows = 60, kLimit = kColumns * kRows / 20;
  constexpr double kMiddleEast_m = 500000 + kColumns / 2.0, kMiddleNorth_m = 5000000 + kRows / 2.0;
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("4711.tif");
  std::vector<Patch> patches;
  for (int row = 0; row < kRows; ++row)
    for (int column = 0; column < kColumns; ++column)
      patches.push_back(SomePatch(500000 + column, 5000000 + row));
  database.AddSource(source, patches);
  const Bounds all{499999, 4999999, 501000, 5001000};
  EXPECT_EQ(database.FindPatchesIn(all).size(), patches.size());
  const auto some = database.FindPatchesIn(all, kLimit);
  EXPECT_NEAR(static_cast<double>(some.size()), kLimit, 0.1 * kLimit);
  std::array<int, 4> quarters{};
  for (const Patch& patch : some) {
    const int east = patch.ground_m.x() >= kMiddleEast_m ? 1 : 0;
    const int north = patch.ground_m.y() >= kMiddleNorth_m ? 1 : 0;
    ++quarters[static_cast<std::size_t>(east + 2 * north)];
  }
  for (const int quarter : quarters) EXPECT_GT(quarter, kLimit / 8);
}

TEST_F(PatchDatabaseTest, FindsExactlyThePatchesInside) {
  const PatchDatabase database = Filled(500);
  const auto all = database.ListPatches(0, 1000);
  ASSERT_EQ(all.size(), 500u);
  const Bounds bounds{502000, 5001000, 506000, 5004000};
  std::vector<std::int64_t> expected, found;
  for (const Patch& patch : all)
    if (bounds.Contains(patch.ground_m.x(), patch.ground_m.y())) expected.push_back(patch.id);
  for (const Patch& patch : database.FindPatchesIn(bounds)) found.push_back(patch.id);
  EXPECT_EQ(found, expected);
  EXPECT_GT(found.size(), 20u);
  EXPECT_TRUE(database.FindPatchesIn({0, 0, 1000, 1000}).empty());
}

TEST_F(PatchDatabaseTest, SpatialIndexFollowsEveryChange) {
  Filled(300);
  {
    PatchDatabase database = PatchDatabase::Open(path_, Mode::kWrite);
    PatchSource more = Photo("4712.tif");
    std::vector<Patch> patches = {SomePatch(1000, 2000)};
    database.AddSource(more, patches);
  }
  SQLite::Database raw(path_, SQLite::OPEN_READONLY);
  EXPECT_EQ(raw.execAndGet("SELECT rtreecheck('rtree_patches_geom')").getString(), "ok");
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM rtree_patches_geom").getInt(), 301);
  EXPECT_EQ(raw.execAndGet("SELECT count(*) FROM patches AS p JOIN rtree_patches_geom AS r USING "
                           "(id)")
                .getInt(),
            301);
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).FindPatchesIn({999, 1999, 1001, 2001}).size(),
            1u);
}

TEST_F(PatchDatabaseTest, InfoCountsAndBounds) {
  PatchDatabase database = Filled(40);
  const PatchDatabaseInfo info = database.Info();
  EXPECT_EQ(info.patches, 40);
  EXPECT_EQ(info.sources, 1);
  EXPECT_EQ(info.attempts, 0);
  EXPECT_EQ(info.schema_version, CurrentSchemaVersion());
  EXPECT_EQ(info.crs_name, Utm().Name());
  for (const Patch& patch : database.ListPatches(0, 100))
    EXPECT_TRUE(info.extent.Contains(patch.ground_m.x(), patch.ground_m.y()));
  EXPECT_TRUE(database.GroundCrs().SameAs(Utm()));
}

TEST_F(PatchDatabaseTest, CrsWithoutEpsgCodeRoundtrips) {
  const Crs crs = Crs::Parse("+proj=tmerc +lon_0=25 +datum=WGS84 +units=m", "test");
  PatchDatabase::Create(path_, crs);
  EXPECT_TRUE(PatchDatabase::Open(path_, Mode::kRead).GroundCrs().SameAs(crs));
}

TEST_F(PatchDatabaseTest, AttemptOfTheSamePhotoReplacesTheEarlierOne) {
  PatchDatabase database = Filled(3);
  database.RecordAttempts({{1, "p", "not_found", {}, {}, "no peak"},
                           {2, "p", "matched", 0.9, Eigen::Vector2d(0.1, -0.2), ""}});
  database.RecordAttempts({{1, "p", "matched", 0.8, Eigen::Vector2d(0.3, 0.4), ""}});
  EXPECT_EQ(database.Info().attempts, 2);
}

TEST_F(PatchDatabaseTest, AttemptsAreStoredTogetherOrNotAtAll) {
  PatchDatabase database = Filled(3);
  EXPECT_THROW(database.RecordAttempts(
                   {{1, "p", "matched", 0.9, {}, ""}, {999, "p", "matched", 0.9, {}, ""}}),
               InputError);
  EXPECT_EQ(database.Info().attempts, 0);
}

TEST_F(PatchDatabaseTest, SourceIsHarvestedOnce) {
  PatchDatabase database = Filled(3);
  PatchSource again = Photo("4711.tif");
  std::vector<Patch> patches = {SomePatch(0, 0)};
  const std::string message = WhatIsWrong([&] { database.AddSource(again, patches); });
  EXPECT_NE(message.find("4711.tif"), std::string::npos) << message;
  EXPECT_EQ(database.Info().patches, 3);
  EXPECT_TRUE(database.HasSource(SourceKind::kPhoto, "4711.tif"));
  EXPECT_FALSE(database.HasSource(SourceKind::kOrthophoto, "4711.tif"));
}

TEST_F(PatchDatabaseTest, BadPatchStoresNothing) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("a");
  std::vector<Patch> patches = {SomePatch(1, 1), SomePatch(2, 2)};
  patches[1].heights.size = 5;
  EXPECT_THROW(database.AddSource(source, patches), std::invalid_argument);
  patches[1] = SomePatch(2, 2);
  patches[1].bits = 12;
  EXPECT_THROW(database.AddSource(source, patches), std::invalid_argument);
  EXPECT_EQ(database.Info().patches, 0);
  EXPECT_EQ(database.Info().sources, 0);
}

TEST_F(PatchDatabaseTest, ReadOnlyRefusesToWrite) {
  Filled(1);
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_THROW(database.RecordAttempts({}), std::invalid_argument);
}

TEST_F(PatchDatabaseTest, MistypedPathNeverMakesAFile) {
  for (const Mode mode : {Mode::kRead, Mode::kWrite})
    EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, mode); }).find(path_),
              std::string::npos);
  EXPECT_FALSE(fs::exists(path_));
  EXPECT_TRUE(fs::is_empty(folder_.Path()));
}

TEST_F(PatchDatabaseTest, CreateNeverOverwrites) {
  Filled(2);
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Create(path_, Utm()); }).find("exists already"),
            std::string::npos);
  EXPECT_EQ(PatchDatabase::Open(path_, Mode::kRead).Info().patches, 2);
}

TEST_F(PatchDatabaseTest, CreateInAMissingFolderSaysSo) {
  const std::string path = folder_ / "nowhere/patches.gpkg";
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Create(path, Utm()); }).find(path), std::string::npos);
}

TEST_F(PatchDatabaseTest, ClosedFileLeavesNothingBesideIt) {
  Filled(2);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.Path()), fs::directory_iterator()), 1);
}

TEST_F(PatchDatabaseTest, ReaderSeesWholeSourcesWhileAWriterHasTheFileOpen) {
  PatchDatabase writer = Filled(5);
  const PatchDatabase reader = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(reader.Info().patches, 5);
  PatchSource more = Photo("4712.tif");
  std::vector<Patch> patches = {SomePatch(1000, 2000)};
  writer.AddSource(more, patches);
  EXPECT_EQ(reader.Info().patches, 6);
}

TEST_F(PatchDatabaseTest, NewerSchemaIsRefusedNamingBothVersions) {
  Filled(1);
  Execute("INSERT INTO orient_schema VALUES (7, 'from the future')");
  const std::string message = WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); });
  EXPECT_NE(message.find("version 7"), std::string::npos) << message;
  EXPECT_NE(message.find("knows 2"), std::string::npos) << message;
}

TEST_F(PatchDatabaseTest, OtherFilesAreRefusedByName) {
  std::ofstream(path_) << "this is a text file, and long enough to look like something else";
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kRead); }).find(path_),
            std::string::npos);
  std::ofstream(path_, std::ios::trunc).close();
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kWrite); }).find("not a GeoPackage"),
            std::string::npos);
  EXPECT_NE(WhatIsWrong([&] { PatchDatabase::Open(folder_.Path(), Mode::kRead); }), "");
}

TEST_F(PatchDatabaseTest, TruncatedFileIsAnInputError) {
  Filled(100);
  const auto size = fs::file_size(path_);
  for (const double share : {0.01, 0.1, 0.3, 0.6, 0.9}) {
    const std::string copy = folder_ / "cut.gpkg";
    fs::copy_file(path_, copy, fs::copy_options::overwrite_existing);
    fs::resize_file(copy, static_cast<std::uintmax_t>(static_cast<double>(size) * share));
    EXPECT_THROW(PatchDatabase::Open(copy, Mode::kRead).ListPatches(0, 1000), InputError) << share;
  }
}

TEST_F(PatchDatabaseTest, DamagedValuesAreAnInputErrorNamingThePatch) {
  const std::string damages[] = {
      "chip = x'89504e470d0a1a0a'",   "chip_mask = x'00'", "heights = x'0000'",
      "heights_size = 2147483647",    "covariance = x''",  "gsd_m = -1",
      "geom = x'475000010000000001'", "chip = 'text'",     "heights_step_m = 'a'"};
  for (const std::string& damage : damages) {
    fs::remove(path_);
    Filled(2);
    std::string sql;  // a shell without the spatial functions cannot run the index's triggers
    if (damage.starts_with("geom"))
      sql +=
          "DROP TRIGGER rtree_patches_geom_update1; DROP TRIGGER rtree_patches_geom_update2; "
          "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; ";
    else
      sql += "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; ";
    sql += "UPDATE patches SET ";
    sql += damage;
    sql += " WHERE id = 2";
    Execute(sql);
    const std::string message =
        WhatIsWrong([&] { PatchDatabase::Open(path_, Mode::kRead).ListPatches(0, 10); });
    EXPECT_NE(message.find("patch 2"), std::string::npos) << damage << ": " << message;
    EXPECT_NE(message.find(path_), std::string::npos) << damage << ": " << message;
  }
}

TEST_F(PatchDatabaseTest, RandomDamageNeverCrashes) {
  Filled(30);
  std::mt19937 random(TestSeed());
  std::ifstream file(path_, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(file)), {});
  for (int round = 0; round < 60; ++round) {
    std::string bytes = whole;
    for (int i = 0; i < 40; ++i) bytes[random() % bytes.size()] = static_cast<char>(random());
    const std::string copy = folder_ / "damaged.gpkg";
    std::ofstream(copy, std::ios::binary | std::ios::trunc) << bytes;
    try {
      const PatchDatabase database = PatchDatabase::Open(copy, Mode::kRead);
      database.Info();
      database.FindPatchesIn({0, 0, 1e7, 1e7});
      database.ListPatches(0, 100);
    } catch (const InputError&) {
    }
  }
}

TEST_F(PatchDatabaseTest, IsAValidGeoPackage) {
  const std::string validator =
      "/usr/lib/python3/dist-packages/osgeo_utils/samples/validate_gpkg.py";
  if (!fs::exists(validator) || !fs::exists("/usr/bin/python3"))
    GTEST_SKIP() << "GDAL's validate_gpkg.py is absent (Debian's python3-gdal)";
  Filled(20).RecordAttempts({{1, "p", "matched", 0.9, Eigen::Vector2d(0, 1), ""}});
  const std::string log = folder_ / "log.txt";
  const int status = std::system(("/usr/bin/python3 " + validator + " --extra --warning-as-error " +
                                  path_ + " > " + log + " 2>&1")
                                     .c_str());
  std::ifstream file(log);
  EXPECT_EQ(status, 0) << std::string((std::istreambuf_iterator<char>(file)), {});
}

TEST_F(PatchDatabaseTest, GdalReadsThePatchesAsPoints) {
  if (!fs::exists("/usr/bin/ogrinfo")) GTEST_SKIP() << "ogrinfo is absent (Debian's gdal-bin)";
  Filled(20);
  const std::string log = folder_ / "log.txt";
  EXPECT_EQ(std::system(("ogrinfo -ro -al -so " + path_ + " > " + log + " 2>&1").c_str()), 0);
  std::ifstream file(log);
  const std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(text.find("3D Point"), std::string::npos) << text;
  EXPECT_NE(text.find("Feature Count: 20"), std::string::npos) << text;
  EXPECT_NE(text.find("UTM zone 35N"), std::string::npos) << text;
  EXPECT_EQ(text.find("Warning"), std::string::npos) << text;
}

}  // namespace
}  // namespace orient
