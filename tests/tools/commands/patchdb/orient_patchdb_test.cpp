#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class PatchdbCommandTest : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string database_ = folder_ / "patches.gpkg";
};

TEST_F(PatchdbCommandTest, CreatesAndDescribesAnEmptyDatabase) {
  EXPECT_EQ(RunOrient({"patchdb", "create", database_, "--crs", "EPSG:32635"}).exit_code, 0);
  const ProgramRun info = RunOrient({"patchdb", "info", database_});
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_TRUE(Contains(info.out, "WGS 84 / UTM zone 35N")) << info.out;
  EXPECT_TRUE(Contains(info.out, "patches   0")) << info.out;
}

TEST_F(PatchdbCommandTest, GeographicCrsIsBadInput) {
  const ProgramRun outcome = RunOrient({"patchdb", "create", database_, "--crs", "EPSG:4326"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "--crs")) << outcome.err;
  EXPECT_FALSE(std::filesystem::exists(database_));
}

TEST_F(PatchdbCommandTest, MissingDatabaseIsBadInputAndIsNotMade) {
  for (const char* verb : {"info", "list"}) {
    const ProgramRun outcome = RunOrient({"patchdb", verb, database_});
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_TRUE(Contains(outcome.err, database_)) << outcome.err;
  }
  EXPECT_FALSE(std::filesystem::exists(database_));
}

TEST_F(PatchdbCommandTest, WithoutAVerbIsBadUsage) {
  EXPECT_EQ(RunOrient({"patchdb"}).exit_code, 1);
  EXPECT_EQ(RunOrient({"patchdb", "create", database_}).exit_code, 1);
}

TEST_F(PatchdbCommandTest, EvenChipIsBadUsage) {
  const ProgramRun outcome = RunOrient({"patchdb", "harvest-ortho", database_, "--ortho", "a.tif",
                                        "--dem", "d.tif", "--chip-px", "60"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_TRUE(Contains(outcome.err, "odd")) << outcome.err;
}

class PatchdbCommandOnRealPhotos : public PatchdbCommandTest {
 protected:
  void SetUp() override {
    const auto ngi = SharedData("ngi");
    if (!ngi) GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): ngi";
    ngi_ = *ngi;
    photo_ = ngi_ + "/photos/3324c_2015_1004_05_0182_RGB.tif";
    RunOrient({"patchdb", "create", database_, "--crs", ngi_ + "/published_orientation.prj"});
  }
  ProgramRun Harvest(const std::string& orientation, const std::string& dem,
                     const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"patchdb",
                                      "harvest",
                                      database_,
                                      "--camera",
                                      ngi_ + "/camera.toml",
                                      "--orientation",
                                      orientation,
                                      "--dem",
                                      dem,
                                      "--spacing-px",
                                      "80",
                                      photo_};
    words.insert(words.end(), more.begin(), more.end());
    return RunOrient(words);
  }
  std::string ngi_, photo_;
};

TEST_F(PatchdbCommandOnRealPhotos, HarvestsOnceAndSaysSoTheSecondTime) {
  const auto harvest = [&](const std::vector<std::string>& more = {}) {
    return Harvest(ngi_ + "/published_orientation.csv", ngi_ + "/dem.tif", more);
  };
  EXPECT_EQ(harvest({"--plan"}).out, "do    harvest   " + photo_ + "\n");
  const ProgramRun first = harvest();
  EXPECT_EQ(first.exit_code, 0) << first.err;
  EXPECT_TRUE(Contains(first.out, "without --dsm roofs and trees cannot")) << first.out;
  const ProgramRun list = RunOrient({"patchdb", "list", database_});
  const auto lines = std::count(list.out.begin(), list.out.end(), '\n');
  EXPECT_GT(lines, 50);
  EXPECT_EQ(harvest({"--plan"}).out, "keep  harvest   " + photo_ + "\n");
  const ProgramRun second = harvest();
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_TRUE(Contains(second.out, "in the database already")) << second.out;
  const ProgramRun again = RunOrient({"patchdb", "list", database_});
  EXPECT_EQ(again.out, list.out);
}

TEST_F(PatchdbCommandOnRealPhotos, HarvestsOrthophotos) {
  const ProgramRun outcome =
      RunOrient({"patchdb", "harvest-ortho", database_, "--ortho",
                 ngi_ + "/orthos/ngi_rgb_byte_1.tif", "--dem", ngi_ + "/dem.tif", "--dsm",
                 ngi_ + "/dem.tif", "--spacing-px", "80", "--date", "2015"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(Contains(outcome.out, "without --dsm")) << outcome.out;
  const ProgramRun info = RunOrient({"patchdb", "info", database_});
  EXPECT_TRUE(Contains(info.out, "orthophoto  2015")) << info.out;
}

TEST_F(PatchdbCommandOnRealPhotos, TableWithoutThePhotoNamesBoth) {
  const std::string table = folder_ / "other.csv";
  std::ofstream(table) << "filename,x,y,z,omega,phi,kappa\nother,1,2,3,0,0,0\n";
  const ProgramRun outcome = Harvest(table, ngi_ + "/dem.tif");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, table)) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "3324c_2015_1004_05_0182_RGB")) << outcome.err;
}

TEST_F(PatchdbCommandOnRealPhotos, PhotoFarFromTheDemIsBadInput) {
  const std::string table = folder_ / "far.csv";
  std::ofstream(table) << "filename,x,y,z,omega,phi,kappa\n"
                       << "3324c_2015_1004_05_0182_RGB,100000,-3000000,5258,0,0,0\n";
  const ProgramRun outcome = Harvest(table, ngi_ + "/dem.tif");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "dem.tif")) << outcome.err;
}

TEST_F(PatchdbCommandOnRealPhotos, TableInAnotherCrsIsBadInput) {
  const std::string table = folder_ / "utm.csv";
  std::filesystem::copy_file(ngi_ + "/published_orientation.csv", table);
  std::ofstream(folder_ / "utm.prj") << "EPSG:32735";
  const ProgramRun outcome = Harvest(table, ngi_ + "/dem.tif");
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "utm.csv")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

TEST_F(PatchdbCommandOnRealPhotos, ImageOfAnotherSizeIsBadInput) {
  const std::string table = folder_ / "dem.csv";
  std::ofstream(table) << "filename,x,y,z,omega,phi,kappa\ndem,-55094,-3727407,5258,0,0,0\n";
  const ProgramRun outcome =
      RunOrient({"patchdb", "harvest", database_, "--camera", ngi_ + "/camera.toml",
                 "--orientation", table, "--dem", ngi_ + "/dem.tif", ngi_ + "/dem.tif"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_TRUE(Contains(outcome.err, "327 x 508 px")) << outcome.err;
  EXPECT_TRUE(Contains(outcome.err, "640 x 1152 px")) << outcome.err;
}

}  // namespace
}  // namespace orient
