#include "patchdb/regions/control_patches.h"

#include <set>
#include <utility>

#include "tests/patchdb/regions/regions_fixture.h"

namespace orient::patchdb {
namespace {

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

}  // namespace
}  // namespace orient::patchdb
