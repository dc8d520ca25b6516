#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/files/results.h"
#include "tests/support/film_frame.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

class InteriorCommandTest : public testing::Test {
 protected:
  void SetUp() override {
    const CameraFile camera = RingCamera(30, 70);
    WriteCameraFile(camera_, camera);
    FilmFrameSpec spec;
    spec.camera = camera;
    WriteScan(scan_, RenderFilmFrame(spec).scan);
  }
  std::vector<std::string> Arguments(const std::string& photo) const {
    return {"interior", photo, "--camera", camera_, "--out", out_, "--pixel-size-um", "100"};
  }
  TemporaryFolder folder_;
  std::string camera_ = folder_ / "camera.toml", scan_ = folder_ / "4711.png",
              out_ = folder_ / "out";
};

TEST_F(InteriorCommandTest, WritesResultPictureAndSummary) {
  const ProgramRun outcome = RunOrient(Arguments(scan_));
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("4711"), std::string::npos);
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(out_, "4711")).status, Status::kOk);
  EXPECT_TRUE(fs::exists(out_ + "/4711.marks.png"));
}

TEST_F(InteriorCommandTest, ASecondRunNeedsOverwriteOrResume) {
  ASSERT_EQ(RunOrient(Arguments(scan_)).exit_code, 0);
  const ProgramRun refused = RunOrient(Arguments(scan_));
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("--resume"), std::string::npos);
  for (const char* way : {"--resume", "--overwrite"}) {
    std::vector<std::string> arguments = Arguments(scan_);
    arguments.push_back(way);
    EXPECT_EQ(RunOrient(arguments).exit_code, 0) << way;
  }
}

TEST_F(InteriorCommandTest, TheScannerMayBeNamed) {
  for (const char* scanner : {"photogrammetric", "desktop", "auto"}) {
    std::vector<std::string> arguments = Arguments(scan_);
    for (const char* word : {"--overwrite", "--scanner", scanner}) arguments.emplace_back(word);
    EXPECT_EQ(RunOrient(arguments).exit_code, 0) << scanner;
  }
  std::vector<std::string> arguments = Arguments(scan_);
  for (const char* word : {"--overwrite", "--scanner", "drum"}) arguments.emplace_back(word);
  EXPECT_EQ(RunOrient(arguments).exit_code, 1);
}

TEST_F(InteriorCommandTest, ADamagedScanFailsAlone) {
  const std::string broken = folder_ / "broken.png";
  std::ofstream(broken) << "not an image";
  std::vector<std::string> arguments = Arguments(scan_);
  arguments.insert(arguments.begin() + 1, broken);
  EXPECT_EQ(RunOrient(arguments).exit_code, 3);
  const InteriorResult failed = ReadInteriorResult(InteriorResultPath(out_, "broken"));
  EXPECT_EQ(failed.status, Status::kFailed);
  EXPECT_NE(failed.messages.at(0).find("broken.png"), std::string::npos);
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(out_, "4711")).status, Status::kOk);
}

TEST_F(InteriorCommandTest, AMissingScanOrCameraIsBadInput) {
  EXPECT_EQ(RunOrient(Arguments(folder_ / "nowhere*.tif")).exit_code, 2);
  fs::remove(camera_);
  EXPECT_EQ(RunOrient(Arguments(scan_)).exit_code, 2);
}

TEST_F(InteriorCommandTest, APictureThatIsNoCutOutMarkIsBadInput) {
  CameraFile camera = RingCamera(30, 70);
  MarkDrawing& mark = camera.marks.at("corner");
  mark.elements.clear();
  mark.image = MarkImage{scan_, 0.1, {20, 20}};  // the whole scan
  WriteCameraFile(camera_, camera);
  const ProgramRun whole = RunOrient(Arguments(scan_));
  EXPECT_EQ(whole.exit_code, 2);
  EXPECT_NE(whole.err.find("cut the mark out"), std::string::npos) << whole.err;
  mark.image = MarkImage{scan_, 0.01, {1e5, 20}};
  WriteCameraFile(camera_, camera);
  const ProgramRun outside = RunOrient(Arguments(scan_));
  EXPECT_EQ(outside.exit_code, 2);
  EXPECT_NE(outside.err.find("centre_px"), std::string::npos) << outside.err;
}

TEST_F(InteriorCommandTest, AnUnknownOrientationIsBadUsage) {
  std::vector<std::string> arguments = Arguments(scan_);
  arguments.insert(arguments.end(), {"--orientation", "r45"});
  EXPECT_EQ(RunOrient(arguments).exit_code, 1);
}

}  // namespace
}  // namespace orient
