#include "patchdb/regions/divide.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <stdexcept>

#include "patchdb/maintenance/life.h"
#include "tests/patchdb/regions/regions_fixture.h"

namespace orient::patchdb {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

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

}  // namespace
}  // namespace orient::patchdb
