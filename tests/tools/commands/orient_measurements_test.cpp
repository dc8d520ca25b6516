#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/measurements/measurements.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class MeasurementsCommandTest : public testing::Test {
 protected:
  std::string Write(const std::string& file, const std::string& text) const {
    std::ofstream(folder_ / file) << text;
    return folder_ / file;
  }
  ProgramRun Import(const std::string& from, const std::vector<std::string>& files,
                    const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"measurements", "--from", from, "--out", out_};
    arguments.insert(arguments.end(), files.begin(), files.end());
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunOrient(arguments);
  }
  TemporaryFolder folder_;
  std::string out_ = folder_ / "said";
};

const std::string kPhotos = "photo,point,col,row,sigma\n4711,p1,10,20,1\n";
const std::string kPoints = "point,x,y,z,sigma\np1,500000,5000000,3,0.1\n";

TEST_F(MeasurementsCommandTest, WritesWhatTheFilesHoldAndSaysWhatItAssumed) {
  const ProgramRun run = Import("csv", {Write("photos.csv", kPhotos),
                                        Write("points.csv", "name,x,y,z\np1,500000,5000000,3\n")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("one sigma of 0.05 m (--ground-sigma-m): 1"), std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("0 marks, 1 image points, 1 ground points"), std::string::npos);
  EXPECT_EQ(ReadMeasurements(out_).points.size(), 1u);
}

TEST_F(MeasurementsCommandTest, AFailedImportLeavesNothing) {
  const std::string photos = Write("photos.csv", kPhotos);
  const ProgramRun run =
      Import("csv", {photos, Write("points.csv", kPoints + "p1,500000,5000001,3,0.1\n")});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("points.csv, line 3: point p1 is given a second time"), std::string::npos)
      << run.err;
  EXPECT_FALSE(fs::exists(out_));
}

TEST_F(MeasurementsCommandTest, FilesThatHoldNoPointAreAnError) {
  const ProgramRun run = Import("micmac", {Write("a.xml", "<Other/>")}, {"--sigma", "1"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("a.xml holds no measured point"), std::string::npos) << run.err;
}

TEST_F(MeasurementsCommandTest, OnlyTablesStateAnAccuracyOfImageCoordinates) {
  const ProgramRun run = Import("patb", {Write("a.im", "1 153000.0\n5 10000.0 1.0\n-99\n")});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("--sigma is missing"), std::string::npos) << run.err;
}

TEST_F(MeasurementsCommandTest, AFolderGetsWhatItDoesNotHaveAndKeepsWhatItHas) {
  const std::string photos = Write("photos.csv", kPhotos), points = Write("points.csv", kPoints);
  ASSERT_EQ(Import("csv", {photos}).exit_code, 0);
  ASSERT_EQ(Import("csv", {points}).exit_code, 0);
  EXPECT_EQ(ReadMeasurements(out_).image_points.size(), 1u);
  EXPECT_EQ(Import("csv", {photos}).exit_code, 1) << "needs --overwrite";
  EXPECT_EQ(Import("csv", {photos}, {"--overwrite"}).exit_code, 0);
}

TEST_F(MeasurementsCommandTest, WhatIsReadIsNotReplaced) {
  fs::create_directory(out_);
  const std::string points = Write("said/points.csv", "name,x,y,z\np1,500000,5000000,3\n");
  const ProgramRun run = Import("csv", {points}, {"--overwrite"});
  EXPECT_EQ(run.exit_code, 1) << run.out;
  EXPECT_NE(run.err.find("points.csv is an input"), std::string::npos) << run.err;
}

TEST_F(MeasurementsCommandTest, ImagePointsMayBeFiducialMarks) {
  ASSERT_EQ(Import("csv", {Write("photos.csv", kPhotos)}, {"--marks"}).exit_code, 0);
  ASSERT_EQ(ReadMeasurements(out_).marks.size(), 1u);
  EXPECT_EQ(ReadMeasurements(out_).marks[0].mark, "p1");
}

}  // namespace
}  // namespace orient
