#include <gtest/gtest.h>

#include <filesystem>

#include "core/base/atomic_write.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

class ExteriorCommandTest : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* file : {"4711.tif", "camera.toml"}) WriteFileAtomically(folder_ / file, "");
    std::filesystem::create_directory(folder_ / "out");
  }

  ProgramRun Run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "exterior",         folder_ / "4711.tif",    "--camera", folder_ / "camera.toml",
        "--approximations", folder_ / "absent.csv",  "--dem",    folder_ / "absent.tif",
        "--patchdb",        folder_ / "absent.gpkg", "--out",    folder_ / "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunOrient(arguments);
  }

  void ExpectKept(const std::string& file, const std::string& text,
                  const std::vector<std::string>& more = {}) const {
    WriteFileAtomically(folder_ / ("out/" + file), text);
    const ProgramRun refused = Run(more);
    EXPECT_EQ(refused.exit_code, 1) << refused.err;
    EXPECT_NE(refused.err.find(file), std::string::npos) << refused.err;
    EXPECT_EQ(ReadFile(folder_ / ("out/" + file)), text);
    std::filesystem::remove(folder_ / ("out/" + file));
  }

  TemporaryFolder folder_;
};

const std::string kHeader = "filename,x,y,z,omega,phi,kappa\n";

TEST_F(ExteriorCommandTest, ResultsOfOtherPhotosAreNotReplacedUnlessAsked) {
  for (const char* file : {"orientation.csv", "block.json", "quicklook.png", "4711.exterior.json"})
    ExpectKept(file, "another run's");
}

TEST_F(ExteriorCommandTest, ResumingReplacesNeitherABlocksResultsNorOtherPhotosRows) {
  ExpectKept("block.json", "a block's", {"--resume"});
  ExpectKept("orientation.csv", kHeader + "4712,1,2,3,0,0,0\n", {"--resume"});
  WriteFileAtomically(folder_ / "out/orientation.csv", kHeader + "4711,1,2,3,0,0,0\n");
  EXPECT_EQ(Run({"--resume"}).exit_code, 2) << "goes on, up to the camera file";
}

}  // namespace
}  // namespace orient
