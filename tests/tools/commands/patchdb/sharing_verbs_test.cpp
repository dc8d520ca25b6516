// The verbs that share, check and renew a patch database, as a user types them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
#include "core/raster/raster.h"
#include "tests/support/made_up_patches.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class SharingVerbsTest : public testing::Test {
 protected:
  SharingVerbsTest() { MadeUpDatabase(path_, 4, 3); }
  TemporaryFolder folder_;
  std::string path_ = folder_ / "patches.gpkg";
};

TEST_F(SharingVerbsTest, ExportsEveryForm) {
  const std::string json = folder_ / "a.geojson", csv = folder_ / "a.csv",
                    chips = folder_ / "chips", part = folder_ / "part.gpkg";
  const ProgramRun outcome =
      RunOrient({"patchdb", "export", path_, "--geojson", json, "--csv", csv, "--chips", chips,
                 "--subset", part, "--box", "500050", "4999950", "500250", "5000050"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const std::string points = ReadFile(json);
  EXPECT_TRUE(Contains(points, "\"coordinates\":[27.00127")) << points;  // 500100 E in zone 35
  const std::string table = ReadFile(csv);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 3);
  const Raster chip = Raster::Open(chips + "/2.tif");
  EXPECT_EQ(chip.Width(), 31);
  ASSERT_TRUE(chip.GeoTransform());
  EXPECT_NEAR((*chip.GeoTransform())[0], 500100 - 15.5 * 0.5, 1e-6);
  EXPECT_NEAR((*chip.GeoTransform())[3], 5000000 + 15.5 * 0.5, 1e-6);
  EXPECT_EQ(patchdb::PatchDatabase::Open(part, patchdb::PatchDatabase::Mode::kRead).Info().patches,
            2);
  EXPECT_EQ(RunOrient({"patchdb", "export", path_, "--csv", csv}).exit_code, 1);
  EXPECT_EQ(RunOrient({"patchdb", "export", path_}).exit_code, 1);
  const std::string both = folder_ / "both.txt";
  EXPECT_EQ(RunOrient({"patchdb", "export", path_, "--csv", both, "--geojson", both}).exit_code, 1);
}

TEST_F(SharingVerbsTest, MergeAndUpdateSayWhatTheyDid) {
  const std::string other = folder_ / "other.gpkg";
  {
    patchdb::PatchDatabase database = patchdb::PatchDatabase::Create(other, MadeUpCrs());
    patchdb::PatchSource source = MadeUpSource("2020.tif", "2020");
    std::vector<patchdb::Patch> patches = {MadeUpPatch(500101, 5000000, 77)};
    database.AddSource(source, patches);
  }
  const ProgramRun update = RunOrient({"patchdb", "update", path_, other});
  EXPECT_EQ(update.exit_code, 0) << update.err;
  EXPECT_TRUE(Contains(update.out, "1 older ones retired")) << update.out;
  const ProgramRun merge = RunOrient({"patchdb", "merge", path_, other});
  EXPECT_TRUE(Contains(merge.out, "1 were there already")) << merge.out;
  EXPECT_EQ(RunOrient({"patchdb", "merge", path_, path_}).exit_code, 1);
  EXPECT_EQ(RunOrient({"patchdb", "merge", path_, folder_ / "none.gpkg"}).exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "none.gpkg"));
}

TEST_F(SharingVerbsTest, CheckAndCompact) {
  EXPECT_TRUE(Contains(RunOrient({"patchdb", "check", path_}).out, "is intact"));
  EXPECT_EQ(RunOrient({"patchdb", "check", path_, "--repair"}).exit_code, 0);
  EXPECT_EQ(RunOrient({"patchdb", "compact", path_}).exit_code, 0);
  std::filesystem::resize_file(path_, std::filesystem::file_size(path_) / 2);
  const ProgramRun damaged = RunOrient({"patchdb", "check", path_});
  EXPECT_EQ(damaged.exit_code, 2) << damaged.out;
  EXPECT_TRUE(Contains(damaged.err, path_)) << damaged.err;
}

}  // namespace
}  // namespace orient
