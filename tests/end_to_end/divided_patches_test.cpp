// A block whose patches lie in a folder of regions.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/atomic_write.h"
#include "patchdb/regions/region_index.h"
#include "patchdb/store/patch_database.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using testing::HasSubstr;

class DividedPatches : public testing::Test {
 protected:
  DividedPatches() {
    Simulate(QuickFilm(2), Block());
    HarvestOldPhotos(Block(), Block() + "/patches.gpkg", 200);
    const ProgramRun run =
        RunOrient({"patchdb", "divide", Block() + "/patches.gpkg", Regions(), "--cell-m", "250"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    std::string text = ReadFile(Block() + "/block.toml");
    for (const auto& [whole, divided] :
         {std::pair("\"patches.gpkg\"", "\"regions\""), std::pair("\"out\"", "\"divided\"")})
      text.replace(text.find(whole), std::string(whole).size(), divided);
    WriteFileAtomically(DividedBlock(), text);
  }

  std::string Block() const { return folder_ / "block"; }
  std::string Regions() const { return Block() + "/regions"; }
  std::string DividedBlock() const { return Block() + "/divided.toml"; }
  ExteriorResult Result(const std::string& out, const std::string& photo) const {
    return ReadExteriorResult(ExteriorResultPath(Block() + "/" + out, photo));
  }
  std::int64_t Attempts() const {
    std::int64_t sum = 0;
    for (const std::string& file :
         patchdb::RegionFiles(Regions(), patchdb::ReadRegionIndex(Regions())))
      sum +=
          patchdb::PatchDatabase::Open(file, patchdb::PatchDatabase::Mode::kRead).Info().attempts;
    return sum;
  }
  static ProgramRun Succeeds(const std::vector<std::string>& words) {
    const ProgramRun run = RunOrient(words);
    EXPECT_EQ(run.exit_code, 0) << run.out << run.err;
    return run;
  }

  const TemporaryFolder folder_;
};

TEST_F(DividedPatches, OrientPhotosAsTheWholeDatabaseDoesAndLearnFromParts) {
  EXPECT_THAT(Succeeds({"patchdb", "info", Regions()}).out, HasSubstr("regions"));
  Succeeds({"block", Block() + "/block.toml"});
  Succeeds({"block", DividedBlock(), "--stage", "interior"});
  for (const char* part : {"1/2", "2/2"})
    Succeeds({"block", DividedBlock(), "--stage", "exterior", "--part", part});
  EXPECT_EQ(Attempts(), 0);
  Succeeds({"block", DividedBlock(), "--learn"});
  std::int64_t sought = 0;
  for (const char* photo : {"new_1_1", "new_1_2"}) {
    const ExteriorResult whole = Result("out", photo), divided = Result("divided", photo);
    ASSERT_EQ(divided.status, Status::kOk) << photo;
    ASSERT_EQ(whole.status, Status::kOk) << photo;
    // The same patches in another order.
    EXPECT_LT((divided.pose->position_m - whole.pose->position_m).norm(), 0.01) << photo;
    EXPECT_EQ(divided.patches.size(), whole.patches.size()) << photo;
    for (const PatchResult& patch : divided.patches)
      sought += patch.id >= 1'000'000'000 && patch.state != PatchState::kNotVisible ? 1 : 0;
  }
  EXPECT_GT(sought, 100);
  EXPECT_EQ(Attempts(), sought);

  // What has learnt is not to be learnt again, nor are photos oriented anew.
  const auto made = fs::last_write_time(ExteriorResultPath(Block() + "/divided", "new_1_1"));
  Succeeds({"block", DividedBlock(), "--resume", "--learn"});
  EXPECT_EQ(Attempts(), sought);
  const std::string kept = ExteriorResultPath(Block() + "/divided/stages/exterior", "new_1_1");
  EXPECT_LT(fs::last_write_time(kept), made);
  // A part that finds all done leaves nothing to learn.
  Succeeds({"block", DividedBlock(), "--stage", "exterior", "--part", "1/2", "--resume"});
  EXPECT_FALSE(fs::exists(Block() + "/divided/stages/exterior/not_yet_learnt"));
}

TEST_F(DividedPatches, AreNotUsedByAnIndexOutOfDate) {
  const std::string gone =
      patchdb::RegionFiles(Regions(), patchdb::ReadRegionIndex(Regions())).front();
  fs::remove(gone);
  const ProgramRun run = RunOrient({"block", DividedBlock(), "--stage", "interior"});
  EXPECT_EQ(run.exit_code, 2) << run.out;
  EXPECT_THAT(run.err, HasSubstr(gone + " is not there"));
  EXPECT_THAT(run.err, HasSubstr("orient patchdb index"));
  Succeeds({"patchdb", "index", Regions()});
  Succeeds({"block", DividedBlock(), "--stage", "interior"});
}

TEST_F(DividedPatches, CommandsForOneDatabaseSayThatTheFolderIsNone) {
  for (const char* verb : {"list", "stats", "check"}) {
    const ProgramRun run = RunOrient({"patchdb", verb, Regions()});
    EXPECT_EQ(run.exit_code, 2) << verb;
    EXPECT_THAT(run.err, HasSubstr("is a folder")) << verb;
  }
}

}  // namespace
}  // namespace orient
