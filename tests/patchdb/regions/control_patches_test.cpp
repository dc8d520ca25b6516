#include "patchdb/regions/control_patches.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "patchdb/maintenance/life.h"
#include "patchdb/regions/divide.h"
#include "patchdb/store/content_digest.h"
#include "tests/support/patch_database_fixture.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr Bounds kAll{499000, 4999000, 511000, 5011000};

std::multiset<std::pair<double, double>> PlacesOf(const std::vector<Patch>& patches) {
  std::multiset<std::pair<double, double>> places;
  for (const Patch& patch : patches) places.emplace(patch.ground_m.x(), patch.ground_m.y());
  return places;
}

class RegionsTest : public PatchDatabaseTest {
 protected:
  std::string regions_ = folder_ / "regions";

  RegionIndex Divide(int patches = 100, double cell_m = 5000) {
    return DivideDatabase(Filled(patches), regions_, cell_m);
  }
  std::string InRegions(const std::string& file) { return (fs::path(regions_) / file).string(); }
  // A database of one source and its patches.
  void Region(const std::string& file, PatchSource source, std::vector<Patch> patches,
              const Crs& crs = Utm()) {
    fs::create_directories(regions_);
    PatchDatabase::Create(InRegions(file), crs).AddSource(source, patches);
  }
};

TEST_F(RegionsTest, TheDividedDatabaseOffersThePatchesOfTheWhole) {
  const PatchDatabase whole = Filled(300);
  const RegionIndex index = DivideDatabase(whole, regions_, 4000);
  EXPECT_EQ(index.regions.size(), 9);
  EXPECT_EQ(index.sources.size(), 1);
  const ControlPatches divided = ControlPatches::Open(regions_);
  divided.RequireCurrentIndex();
  for (const Bounds& bounds :
       {kAll, Bounds{502000, 5002000, 505000, 5007000}, Bounds{504000, 5004000, 504100, 5009000}}) {
    const std::vector<Patch> found = divided.FindPatchesIn(bounds);
    EXPECT_EQ(PlacesOf(found), PlacesOf(whole.FindPatchesIn(bounds)));
    for (const Patch& patch : found) {
      const auto read = divided.ReadPatch(patch.id);
      ASSERT_TRUE(read);
      EXPECT_EQ(read->ground_m, patch.ground_m);
      EXPECT_EQ(read->id, patch.id);
      EXPECT_EQ(read->source_id, index.sources.front().id);
    }
  }
  EXPECT_FALSE(divided.ReadPatch(77'000'000'001));
  EXPECT_FALSE(divided.ReadPatch(1'000'099'999));
}

TEST_F(RegionsTest, OfTooManyEachRegionGivesItsShare) {
  Divide(300, 4000);
  const std::vector<Patch> few = ControlPatches::Open(regions_).FindPatchesIn(kAll, 90);
  EXPECT_NEAR(static_cast<double>(few.size()), 90, 40);
  std::set<std::int64_t> regions;
  for (const Patch& patch : few) regions.insert(patch.id / 1'000'000'000);
  EXPECT_GE(regions.size(), 7);
}

TEST_F(RegionsTest, APatchOnTheCommonEdgeIsInOneOfThem) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("4711.tif");
  std::vector<Patch> patches = {SomePatch(504000, 5004000), SomePatch(503999.5, 5004000),
                                SomePatch(504000, 5003999.5)};
  database.AddSource(source, patches);
  const RegionIndex index = DivideDatabase(database, regions_, 4000);
  ASSERT_EQ(index.regions.size(), 3);
  for (const orient::patchdb::Region& region : index.regions) EXPECT_EQ(region.patches, 1);
  EXPECT_TRUE(fs::exists(InRegions("x504000_y5004000.gpkg")));
}

TEST_F(RegionsTest, OneSourceInTwoDatabasesIsOne) {
  PatchSource dated = Photo("ortho.tif");
  dated.digest = "a";
  PatchSource other = dated;
  other.digest = "b";
  Region("east.gpkg", dated, {SomePatch(505000, 5001000)});
  Region("north.gpkg", other, {SomePatch(501000, 5006000)});
  Region("west.gpkg", dated, {SomePatch(501000, 5001000)});
  const RegionIndex index = IndexRegions(regions_);
  EXPECT_EQ(index.sources.size(), 2);
  const std::vector<Patch> found = ControlPatches::Open(regions_).FindPatchesIn(kAll);
  ASSERT_EQ(found.size(), 3);
  EXPECT_EQ(found[0].source_id, found[2].source_id);
  EXPECT_NE(found[0].source_id, found[1].source_id);
}

TEST_F(RegionsTest, WhatTwoRegionsHoldOfOneSourceComesOnce) {
  Region("a.gpkg", Photo("4711.tif"), {SomePatch(501000, 5001000), SomePatch(501500, 5001000)});
  Region("b.gpkg", Photo("4711.tif"), {SomePatch(501500, 5001000), SomePatch(502000, 5001000)});
  Region("c.gpkg", Photo("4712.tif"), {SomePatch(501500, 5001000)});
  IndexRegions(regions_);
  EXPECT_EQ(ControlPatches::Open(regions_).FindPatchesIn(kAll).size(), 4);
}

TEST_F(RegionsTest, ARegionOfOnePatchIsFound) {
  Region("a.gpkg", Photo("4711.tif"), {SomePatch(501000, 5001000)});
  IndexRegions(regions_);
  EXPECT_EQ(ControlPatches::Open(regions_).FindPatchesIn(kAll).size(), 1);
}

TEST_F(RegionsTest, NumbersAndSourcesStayWhenDatabasesComeAndGo) {
  for (const char* name : {"a", "b", "c"})
    Region(name + std::string(".gpkg"), Photo(name), {SomePatch(501000, 5001000)});
  const RegionIndex before = IndexRegions(regions_);
  fs::remove(InRegions("b.gpkg"));
  Region("aa.gpkg", Photo("aa"), {SomePatch(501000, 5001000)});
  const RegionIndex after = IndexRegions(regions_);
  ASSERT_EQ(after.regions.size(), 3);
  EXPECT_EQ(after.regions[0].file, "a.gpkg");
  EXPECT_EQ(after.regions[1].file, "c.gpkg");
  EXPECT_EQ(after.regions[1].number, before.regions[2].number);
  EXPECT_EQ(after.regions[1].sources, before.regions[2].sources);
  EXPECT_EQ(after.regions[2].file, "aa.gpkg");
  EXPECT_EQ(after.regions[2].number, 4);
  fs::remove(InRegions("aa.gpkg"));
  IndexRegions(regions_);
  Region("d.gpkg", Photo("d"), {SomePatch(501000, 5001000)});
  EXPECT_EQ(IndexRegions(regions_).regions.back().number, 5);
}

TEST_F(RegionsTest, AnIndexOutOfDateIsNotUsed) {
  Region("a.gpkg", Photo("4711.tif"), {SomePatch(501000, 5001000)});
  IndexRegions(regions_);
  const auto complaint = [&] {
    return WhatIsWrong([&] { ControlPatches::Open(regions_).RequireCurrentIndex(); });
  };
  EXPECT_EQ(complaint(), "");
  Region("b.gpkg", Photo("4712.tif"), {SomePatch(501000, 5001000)});
  EXPECT_THAT(complaint(), HasSubstr("b.gpkg is not listed"));
  EXPECT_THAT(complaint(), HasSubstr("orient patchdb index " + regions_));
  fs::remove(InRegions("b.gpkg"));
  {
    PatchDatabase grown = PatchDatabase::Open(InRegions("a.gpkg"), PatchDatabase::Mode::kWrite);
    PatchSource source = Photo("4713.tif");
    std::vector<Patch> patches = {SomePatch(501000, 5001000)};
    grown.AddSource(source, patches);
  }
  EXPECT_THAT(complaint(), HasSubstr("a.gpkg was changed"));
  IndexRegions(regions_);
  EXPECT_EQ(complaint(), "");
  fs::remove(InRegions("a.gpkg"));
  EXPECT_THAT(complaint(), HasSubstr("a.gpkg is not there"));
}

// A copy has other times, and attempts change the files: neither makes an index useless.
TEST_F(RegionsTest, ATouchedDatabaseIsLookedAtAndFoundAsListed) {
  Divide();
  for (const auto& entry : fs::directory_iterator(regions_))
    fs::last_write_time(entry.path(), fs::file_time_type::clock::now());
  EXPECT_EQ(WhatIsWrong([&] { ControlPatches::Open(regions_).RequireCurrentIndex(); }), "");
}

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

TEST_F(RegionsTest, ContentChangesWithTheRegionsOfThePhotosAlone) {
  Divide();
  const Bounds here{500500, 5000500, 501000, 5001000}, there{509000, 5009000, 509500, 5009500};
  const auto contents = [&] {
    const ControlPatches patches = ControlPatches::Open(regions_);
    return std::pair(patches.ContentWithin({here}), patches.ContentWithin({there}));
  };
  const auto before = contents();
  {
    PatchDatabase one =
        PatchDatabase::Open(InRegions("x505000_y5005000.gpkg"), PatchDatabase::Mode::kWrite);
    PatchSource source = Photo("4713.tif");
    std::vector<Patch> patches = {SomePatch(509000, 5009000)};
    one.AddSource(source, patches);
  }
  const auto after = contents();
  EXPECT_EQ(after.first, before.first);
  EXPECT_NE(after.second, before.second);
}

TEST_F(RegionsTest, DatabasesOfTwoCrsAreRefused) {
  Region("a.gpkg", Photo("4711.tif"), {SomePatch(501000, 5001000)});
  Region("b.gpkg", Photo("4711.tif"), {SomePatch(501000, 5001000)},
         Crs::Parse("EPSG:32636", "test"));
  EXPECT_THAT(WhatIsWrong([&] { IndexRegions(regions_); }), HasSubstr("b.gpkg: its CRS is"));
}

TEST_F(RegionsTest, AFolderWithoutIndexSaysHowToMakeIt) {
  EXPECT_THAT(WhatIsWrong([&] { ControlPatches::Open(folder_.Path()); }),
              HasSubstr("orient patchdb index"));
  EXPECT_THAT(WhatIsWrong([&] { IndexRegions(folder_.Path()); }), HasSubstr("no patch databases"));
  EXPECT_THAT(WhatIsWrong([&] { PatchDatabase::Open(folder_.Path(), PatchDatabase::Mode::kRead); }),
              HasSubstr("is a folder"));
}

TEST_F(RegionsTest, ADamagedIndexIsAnError) {
  Divide();
  const std::string path = RegionIndexPath(regions_), whole = ReadFile(path);
  const auto complaint = [&](const std::string& text) {
    WriteFileAtomically(path, text);
    return WhatIsWrong([&] { ControlPatches::Open(regions_); });
  };
  // `field` of the first region, or of the whole.
  const auto with = [&](const std::string& field, const std::string& value) {
    const auto at = whole.find("\"" + field + "\": ");
    const auto begin = at + field.size() + 4;
    const char last = whole[begin] == '[' ? ']' : ',';
    const auto end = whole.find(last, begin) + (last == ']' ? 1 : 0);
    return whole.substr(0, begin) + value + whole.substr(end);
  };
  EXPECT_EQ(complaint(whole), "");
  EXPECT_THAT(complaint(whole.substr(0, whole.size() / 2)), HasSubstr("is damaged"));
  EXPECT_THAT(complaint("[]"), HasSubstr("is damaged"));
  EXPECT_THAT(complaint("{\"version\": 2}"), HasSubstr("version 2"));
  for (const auto& [field, value] :
       std::vector<std::pair<std::string, std::string>>{{"file", "\"../a.gpkg\""},
                                                        {"file", "\"..\""},
                                                        {"number", "0"},
                                                        {"number", "4294967297"},
                                                        {"number", "1.5"},
                                                        {"number", "2"},
                                                        {"next_number", "3"},
                                                        {"next_number", "-1"},
                                                        {"next_number", "4294967299"},
                                                        {"extent", "null"},
                                                        {"extent", "[1, 2, 0, 3]"},
                                                        {"extent", "[1, 2, 3]"},
                                                        {"patches", "-3"},
                                                        {"patches", "1e30"},
                                                        {"kind", "\"satellite\""},
                                                        {"id", "2"},
                                                        {"version", "1.5"},
                                                        {"crs", "\"nonsense\""}})
    EXPECT_NE(complaint(with(field, value)), "") << field << " " << value;
}

TEST_F(RegionsTest, AnInterruptedDivisionIsNotTakenForAFolderOfRegions) {
  const PatchDatabase whole = Filled(100);
  EXPECT_THROW(
      DivideDatabase(whole, regions_, 4000, [](int, int) { throw std::runtime_error("killed"); }),
      std::runtime_error);
  EXPECT_THAT(WhatIsWrong([&] { IndexRegions(regions_); }), HasSubstr("repeat"));
  EXPECT_THAT(WhatIsWrong([&] { ControlPatches::Open(regions_); }), HasSubstr("repeat"));
}

// Edges of such cells are no exact numbers.
TEST_F(RegionsTest, EveryPatchIsInACellOfAnySize) {
  PatchDatabase database = PatchDatabase::Create(path_, Utm());
  PatchSource source = Photo("4711.tif");
  std::vector<Patch> patches;
  for (int i = 0; i < 12; ++i) patches.push_back(SomePatch(333.3 * i, -333.3 * i));
  database.AddSource(source, patches);
  std::int64_t count = 0;
  for (const orient::patchdb::Region& region : DivideDatabase(database, regions_, 333.3).regions)
    count += region.patches;
  EXPECT_EQ(count, 12);
}

// A program that writes may be running, or was killed: the database's file is as it was.
TEST_F(RegionsTest, WhatIsInALogIsNoticed) {
  Divide();
  const std::string path = InRegions("x500000_y5000000.gpkg");
  PatchDatabase open = PatchDatabase::Open(path, PatchDatabase::Mode::kWrite);
  PatchSource source = Photo("4713.tif");
  std::vector<Patch> patches = {SomePatch(501000, 5001000)};
  const auto before = fs::last_write_time(path);
  open.AddSource(source, patches);
  fs::last_write_time(path, before);
  EXPECT_THAT(WhatIsWrong([&] { ControlPatches::Open(regions_).RequireCurrentIndex(); }),
              HasSubstr("was changed"));
  EXPECT_EQ(IndexRegions(regions_).sources.size(), 2);
  EXPECT_EQ(WhatIsWrong([&] { ControlPatches::Open(regions_).RequireCurrentIndex(); }), "");
}

TEST_F(RegionsTest, ASourceIsKnownByItsContentWhateverNumberItsNameHas) {
  PatchSource first = Photo("4711.tif"), second = first;
  first.digest = "a";
  second.digest = "b";
  Region("a.gpkg", first, {SomePatch(501000, 5001000)});
  {
    PatchDatabase a = PatchDatabase::Open(InRegions("a.gpkg"), PatchDatabase::Mode::kWrite);
    PatchSource source = second;
    std::vector<Patch> patches = {SomePatch(502000, 5001000)};
    a.AddSource(source, patches);  // "4711.tif (2)"
  }
  Region("b.gpkg", second, {SomePatch(503000, 5001000)});
  EXPECT_EQ(IndexRegions(regions_).sources.size(), 2);
}

TEST_F(RegionsTest, AnInterruptedDivisionGoesOn) {
  const PatchDatabase whole = Filled(300);
  int steps = 0;
  EXPECT_THROW(DivideDatabase(whole, regions_, 4000,
                              [&](int done, int) {
                                steps = done;
                                if (done == 4) throw std::runtime_error("killed");
                              }),
               std::runtime_error);
  EXPECT_THAT(WhatIsWrong([&] { ControlPatches::Open(regions_); }), HasSubstr("interrupted"));
  EXPECT_THAT(WhatIsWrong([&] { DivideDatabase(whole, regions_, 5000); }),
              HasSubstr("interrupted"));
  const auto first = fs::last_write_time(InRegions("x500000_y5000000.gpkg"));
  const RegionIndex index = DivideDatabase(whole, regions_, 4000);
  EXPECT_EQ(index.regions.size(), 9);
  EXPECT_EQ(fs::last_write_time(InRegions("x500000_y5000000.gpkg")), first);
  EXPECT_EQ(PlacesOf(ControlPatches::Open(regions_).FindPatchesIn(kAll)),
            PlacesOf(whole.FindPatchesIn(kAll)));
  EXPECT_THAT(WhatIsWrong([&] { DivideDatabase(whole, regions_, 4000); }),
              HasSubstr("is not empty"));
}

TEST_F(RegionsTest, RetiredPatchesAndHistoriesAreDividedToo) {
  {
    PatchDatabase whole = Filled(50);
    std::vector<MatchAttempt> attempts;
    for (const Patch& patch : whole.FindPatchesIn(kAll)) {
      attempts.push_back({patch.id, "0815", "matched", 0.9, {}, ""});
      attempts.back().photo_digest = "d";
    }
    whole.RecordAttempts(attempts);
    RetirePatches(whole, {1, 2, 3, 4, 5}, "gone");
  }
  const RegionIndex index =
      DivideDatabase(PatchDatabase::Open(path_, PatchDatabase::Mode::kRead), regions_, 4000);
  std::int64_t retired = 0, attempts = 0, patches = 0;
  for (const std::string& file : RegionFiles(regions_, index)) {
    const PatchDatabaseInfo info = PatchDatabase::Open(file, PatchDatabase::Mode::kRead).Info();
    patches += info.patches;
    retired += info.retired;
    attempts += info.attempts;
  }
  EXPECT_EQ(patches, 50);
  EXPECT_EQ(retired, 5);
  EXPECT_EQ(attempts, 50);
  EXPECT_EQ(ControlPatches::Open(regions_).FindPatchesIn(kAll).size(), 45);
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
