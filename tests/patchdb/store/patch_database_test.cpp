#include "patchdb/store/patch_database.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "core/base/error.h"
#include "patchdb/store/schema.h"
#include "tests/support/patch_database_fixture.h"

namespace orient::patchdb {
namespace {

using Mode = PatchDatabase::Mode;

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

TEST_F(PatchDatabaseTest, FurtherViewsAreEvidence) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  const std::vector<PatchSource> witnesses = {Photo("4710.tif"), Photo("4712.tif")};
  PatchSource source = Photo("4711.tif");
  std::vector<Patch> patches = {SomePatch(1, 2), SomePatch(3, 4), SomePatch(5, 6)};
  patches[1].evidence = {{1, Eigen::Vector2d(100.5, 200.25), Eigen::Vector2d(0.125, -0.25)}};
  patches[2].evidence = {{1, Eigen::Vector2d(10, 20), {}}};
  database.AddSource(source, patches, witnesses);
  const KnownSource witness = database.FindSource(witnesses[1]);
  ASSERT_TRUE(witness.id);
  EXPECT_FALSE(witness.harvested);
  EXPECT_FALSE(database.FindSource(witnesses[0]).id) << "shows none of them";
  const auto read = database.ReadPatch(2);
  EXPECT_EQ(read->views, 2);
  ASSERT_EQ(read->evidence.size(), 1u);
  EXPECT_EQ(read->evidence[0].source_id, witness.id);
  EXPECT_EQ(read->evidence[0].pixel, Eigen::Vector2d(100.5, 200.25));
  EXPECT_EQ(read->evidence[0].residual_px, Eigen::Vector2d(0.125, -0.25));
  EXPECT_EQ(patches[2].evidence[0].source_id, witness.id);
  EXPECT_EQ(database.ReadPatch(1)->views, 1);
  EXPECT_EQ(database.Info().sources, 1);
}

TEST_F(PatchDatabaseTest, NamedSourceIsHarvestedLater) {
  PatchDatabase database = Filled(3);
  PatchSource named = Photo("4712.tif"), first = Photo("4713.tif"), last = Photo("4714.tif");
  std::vector<Patch> patches = {SomePatch(1, 2)}, seen = {SomePatch(3, 4)};
  seen[0].evidence = {{0, {}, {}}};
  database.AddSource(first, seen, {named});
  const auto id = database.FindSource(named).id;
  ASSERT_TRUE(id);
  named.gsd_m = 0.25;
  database.AddSource(named, patches);
  EXPECT_EQ(named.id, id);
  EXPECT_TRUE(database.FindSource(named).harvested);
  EXPECT_EQ(database.Sources().back().gsd_m, 0.25);
  seen = {SomePatch(5, 6)};
  seen[0].evidence = {{0, {}, {}}};
  database.AddSource(last, seen, {named});
  EXPECT_EQ(seen[0].evidence[0].source_id, id);
  EXPECT_TRUE(database.FindSource(named).harvested);
}

TEST_F(PatchDatabaseTest, ReaderIsToldThatItMayNotAdd) {
  Filled(3);
  PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  PatchSource source = Photo("4712.tif");
  std::vector<Patch> patches = {SomePatch(1, 2)};
  patches[0].evidence = {{0, {}, {}}};
  try {
    database.AddSource(source, patches, {Photo("4713.tif")});
    ADD_FAILURE() << "a reader added a source";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(error.what(), path_ + " was opened read-only");
  }
  EXPECT_EQ(database.Info().sources, 1);
}

TEST_F(PatchDatabaseTest, SourcesOfOneNameAreToldApartByTheirContent) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  for (const char* digest : {"0123", "4567"}) {
    PatchSource source = Photo("4711.tif");
    source.digest = digest;
    std::vector<Patch> patches = {SomePatch(1, 2)};
    EXPECT_FALSE(database.FindSource(source).id);
    database.AddSource(source, patches);
    EXPECT_TRUE(database.FindSource(source).harvested);
    source.name = "4711.tif";
    EXPECT_TRUE(database.FindSource(source).harvested);
    EXPECT_NE(WhatIsWrong([&] { database.AddSource(source, patches); }), "");
  }
  EXPECT_EQ(database.Sources()[1].name, "4711.tif (2)");
  EXPECT_EQ(database.Sources()[1].digest, "4567");
}

TEST_F(PatchDatabaseTest, RetiredPatchesDoNotCrowdOthersOut) {
  Filled(400);
  Execute(
      "DROP TRIGGER rtree_patches_geom_update3; DROP TRIGGER rtree_patches_geom_update4; "
      "UPDATE patches SET state = 'retired', retired_reason = 'a roof' WHERE id > 40");
  const PatchDatabase database = PatchDatabase::Open(path_, Mode::kRead);
  EXPECT_EQ(database.FindPatchesIn({0, 0, 1e7, 1e7}, 40).size(), 40u);
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

TEST_F(PatchDatabaseTest, SourceIsHarvestedOnce) {
  PatchDatabase database = Filled(3);
  PatchSource again = Photo("4711.tif");
  std::vector<Patch> patches = {SomePatch(0, 0)};
  const std::string message = WhatIsWrong([&] { database.AddSource(again, patches); });
  EXPECT_NE(message.find("4711.tif"), std::string::npos) << message;
  EXPECT_EQ(database.Info().patches, 3);
  EXPECT_TRUE(database.FindSource(again).harvested);
  again.kind = SourceKind::kOrthophoto;
  EXPECT_FALSE(database.FindSource(again).id);
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

}  // namespace
}  // namespace orient::patchdb
