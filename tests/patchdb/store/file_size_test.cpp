// How much larger a database is than its chips.
#include <SQLiteCpp/SQLiteCpp.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "patchdb/store/patch_database.h"
#include "tests/support/shared_data.h"

namespace orient::patchdb {
namespace {

// Chips as large as those of photos: noise, which no PNG makes smaller.
std::vector<Patch> NoisyPatches(int count) {
  std::mt19937 random(TestSeed());
  std::uniform_int_distribution<int> grey(0, 255);
  std::vector<Patch> patches;
  for (int i = 0; i < count; ++i) {
    Patch patch;
    patch.ground_m = {500000 + 60.0 * (i % 30), 5000000 + 60.0 * (i / 30), 123.5};
    patch.covariance_m2 = Eigen::Matrix3d::Identity();
    patch.gsd_m = 0.25;
    patch.chip = Image(49, 49);
    for (float& value : patch.chip.values) value = static_cast<float>(grey(random));
    patch.heights = {3, 6, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
    patches.push_back(patch);
  }
  return patches;
}

TEST(FileSize, GrowsByHardlyMoreThanTheChips) {
  const TemporaryFolder folder;
  const std::string path = folder / "patches.gpkg";
  const auto size = [&] { return static_cast<double>(std::filesystem::file_size(path)); };
  PatchDatabase::Create(path, Crs::Parse("EPSG:32635", "test"));
  const double empty = size();
  {
    PatchDatabase database = PatchDatabase::Open(path, PatchDatabase::Mode::kWrite);
    PatchSource source{0, SourceKind::kPhoto, "4711.tif", std::nullopt, 0.25, {}, {}, {}};
    std::vector<Patch> patches = NoisyPatches(900);
    database.AddSource(source, patches);
  }
  SQLite::Database raw(path, SQLite::OPEN_READONLY);
  const double chips = raw.execAndGet("SELECT sum(length(chip)) FROM patches").getDouble();
  EXPECT_LT(size() - empty, 1.3 * chips);
}

}  // namespace
}  // namespace orient::patchdb
