// A block whose file names images of known ground: the run makes its patch database itself.
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>
#include <vector>

#include "core/base/atomic_write.h"
#include "tests/end_to_end/simulated_block.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class BlockControl : public testing::Test {
 protected:
  BlockControl() {
    Simulate(QuickFilm(2), Block());
    std::string text = ReadFile(BlockPath());
    const std::string patchdb = "patchdb = \"patches.gpkg\"\n";
    const auto at = text.find(patchdb);
    if (at == std::string::npos) throw std::runtime_error("no patchdb in " + text);
    text.erase(at, patchdb.size());
    text +=
        "\n[control]\nphotos = [\"old/photos/*.tif\"]\ncamera = \"old/camera.toml\"\n"
        "orientation = \"old/orientation.csv\"\n";
    WriteFileAtomically(BlockPath(), text);
  }

  std::string Block() const { return folder_ / "block"; }
  std::string BlockPath() const { return Block() + "/block.toml"; }
  // Of all that are there.
  std::vector<std::string> Databases() const {
    std::vector<std::string> found;
    if (fs::exists(Block() + "/out"))
      for (const auto& entry : fs::directory_iterator(Block() + "/out"))
        if (entry.path().filename().string().starts_with("control_")) found.push_back(entry.path());
    return found;
  }

  static bool Harvests(const ProgramRun& run) {
    return run.out.find("patches added") != std::string::npos;
  }

  const TemporaryFolder folder_;
};

TEST_F(BlockControl, IsMadeOnceAndAnotherWhereWhatItIsOfHasChanged) {
  const ProgramRun planned = RunOrient({"block", BlockPath(), "--plan"});
  EXPECT_EQ(planned.exit_code, 0) << planned.err;
  EXPECT_NE(planned.out.find(".gpkg is made first"), std::string::npos) << planned.out;
  EXPECT_TRUE(Databases().empty());

  const ProgramRun first = RunOrient({"block", BlockPath()});
  EXPECT_EQ(first.exit_code, 0) << first.out << first.err;
  EXPECT_TRUE(Harvests(first)) << first.out;
  EXPECT_NE(ReadFile(Block() + "/out/run.json").find("control photo"), std::string::npos);
  ASSERT_EQ(Databases().size(), 1u);
  const std::string database = Databases().front();
  const auto made = fs::last_write_time(database);
  for (const char* photo : {"new_1_1", "new_1_2"})
    EXPECT_EQ(ReadExteriorResult(ExteriorResultPath(Block() + "/out", photo)).status, Status::kOk)
        << photo;

  const ProgramRun again = RunOrient({"block", BlockPath(), "--resume"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_FALSE(Harvests(again)) << again.out;
  EXPECT_EQ(fs::last_write_time(database), made);

  // Another date of the images: another database, and the first one is kept.
  WriteFileAtomically(BlockPath(), ReadFile(BlockPath()) + "date = \"1999\"\n");
  const ProgramRun other = RunOrient({"block", BlockPath(), "--resume"});
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_TRUE(Harvests(other)) << other.out;
  EXPECT_EQ(Databases().size(), 2u);
  EXPECT_EQ(fs::last_write_time(database), made);

  // A photo that is missing is named before anything is made.
  fs::remove(Block() + "/old/orientation.csv");
  const ProgramRun missing = RunOrient({"block", BlockPath(), "--resume"});
  EXPECT_EQ(missing.exit_code, 2);
  EXPECT_NE(missing.err.find("orientation.csv, which does not exist"), std::string::npos)
      << missing.err;
}

// A harvest takes hours: what would stop the run after it is told before.
TEST_F(BlockControl, IsNotMadeWhereATableWouldStopTheRunAfterIt) {
  const auto expect_named = [&](const std::string& what) {
    for (const std::vector<std::string>& how :
         std::vector<std::vector<std::string>>{{"--plan"}, {}, {"--stage", "control"}}) {
      std::vector<std::string> arguments = {"block", BlockPath()};
      arguments.insert(arguments.end(), how.begin(), how.end());
      const ProgramRun run = RunOrient(arguments);
      EXPECT_EQ(run.exit_code, 2) << run.out;
      EXPECT_NE(run.err.find(what), std::string::npos) << run.err;
    }
    EXPECT_TRUE(Databases().empty());
  };
  const std::string block = ReadFile(BlockPath()), table = Block() + "/approx.csv";
  WriteFileAtomically(Block() + "/gnss.csv", "filename,x,z\nnew_1_1,0,0\n");
  WriteFileAtomically(BlockPath(), block + "\n[gnss]\npositions = \"gnss.csv\"\nsigma_m = 0.1\n");
  expect_named("gnss.csv");
  WriteFileAtomically(BlockPath(), block);
  WriteFileAtomically(table, "filename,x,y,z,omega,phi,kappa\nanother,500000,5000000,900,0,0,0\n");
  expect_named("approx.csv: none of the given photos is in this table");
}

}  // namespace
}  // namespace orient
