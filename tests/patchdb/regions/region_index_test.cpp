#include "patchdb/regions/region_index.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/atomic_write.h"
#include "tests/patchdb/regions/regions_fixture.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

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

}  // namespace
}  // namespace orient::patchdb
