#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/base/atomic_write.h"
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

TEST_F(InteriorCommandTest, AMisspeltMarkIsBadInput) {
  fs::create_directory(folder_ / "said");
  std::ofstream(folder_ / "said/marks.csv") << "photo,mark,col,row,sigma\n4711,none,10,20,1\n";
  std::vector<std::string> arguments = Arguments(scan_);
  arguments.insert(arguments.end(), {"--measurements", folder_ / "said"});
  const ProgramRun outcome = RunOrient(arguments);
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_NE(outcome.err.find("photo 4711 has a mark \"none\""), std::string::npos) << outcome.err;
  EXPECT_FALSE(fs::exists(out_));
}

class InteriorResumed : public InteriorCommandTest {
 protected:
  void SetUp() override {
    InteriorCommandTest::SetUp();
    ASSERT_EQ(RunOrient(Arguments(scan_)).exit_code, 0);
  }
  ProgramRun Resume(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = Arguments(scan_);
    arguments.push_back("--resume");
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunOrient(arguments);
  }
  void ExpectRefused(const ProgramRun& run, const std::string& changed) const {
    EXPECT_EQ(run.exit_code, 1);
    EXPECT_NE(run.err.find("4711.interior.json was made from other inputs (" + changed),
              std::string::npos)
        << run.err;
  }
};

TEST_F(InteriorResumed, APlanTellsWhatTheRunWouldDo) {
  EXPECT_EQ(Resume({"--plan"}).out, "keep  interior  4711\n");
  ExpectRefused(Resume({"--plan", "--polarity", "positive"}), "options");
  std::vector<std::string> anew = Arguments(scan_);
  anew.insert(anew.end(), {"--plan", "--overwrite"});
  EXPECT_EQ(RunOrient(anew).out, "do    interior  4711\n");
  WriteFileAtomically(InteriorResultPath(out_, "4711"), "{");
  EXPECT_EQ(Resume({"--plan"}).out, "do    interior  4711\n");
  EXPECT_EQ(ReadFile(InteriorResultPath(out_, "4711")), "{");
}

TEST_F(InteriorResumed, TakesNothingOverFromAnotherCamera) {
  CameraFile camera = RingCamera(30, 70);
  camera.fiducials[0].position_mm.x() += 0.01;
  WriteCameraFile(camera_, camera);
  ExpectRefused(Resume(), "camera file");
}

TEST_F(InteriorResumed, TakesNothingOverFromOtherOptions) {
  ExpectRefused(Resume({"--scanner", "photogrammetric"}), "options");
}

TEST_F(InteriorResumed, TakesNothingOverFromAnotherScan) {
  FilmFrameSpec spec;
  spec.camera = RingCamera(30, 70);
  spec.seed = 99;
  WriteScan(scan_, RenderFilmFrame(spec).scan);
  ExpectRefused(Resume(), "scan");
}

TEST_F(InteriorResumed, KeepsAResultWhoseScanWasMovedAway) {
  fs::remove(scan_);
  EXPECT_NE(Resume().exit_code, 0);  // a photo that is not there is bad input
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(out_, "4711")).status, Status::kOk);
}

TEST_F(InteriorResumed, DoesAPhotoAgainWhoseResultIsDamaged) {
  std::ofstream(InteriorResultPath(out_, "4711"), std::ios::trunc) << "{";
  EXPECT_EQ(Resume().exit_code, 0);
  EXPECT_EQ(ReadInteriorResult(InteriorResultPath(out_, "4711")).status, Status::kOk);
}

TEST_F(InteriorResumed, AnotherPhotoOfTheCameraJoinsTheTables) {
  const std::string second = folder_ / "4712.png";
  fs::copy(scan_, second);
  ASSERT_EQ(RunOrient(Arguments(second)).exit_code, 0);
  std::ifstream table(out_ + "/interior.csv");
  const std::string text{std::istreambuf_iterator<char>(table), {}};
  EXPECT_NE(text.find("4711,ok"), std::string::npos) << text;
  EXPECT_NE(text.find("4712,ok"), std::string::npos) << text;
}

TEST_F(InteriorCommandTest, AnOpenOrientationIsSeenInTheTables) {
  const ProgramRun run = RunOrient(Arguments(scan_));
  ASSERT_EQ(run.exit_code, 0);
  EXPECT_NE(run.out.find("open (8)"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("--orientation settles it"), std::string::npos) << run.out;
  EXPECT_NE(ReadFile(out_ + "/interior.csv").find(",open,r0 "), std::string::npos);
}

TEST_F(InteriorCommandTest, TablesOfAnotherCameraAreNotReplacedUnlessAsked) {
  ASSERT_EQ(RunOrient(Arguments(scan_)).exit_code, 0);
  CameraFile other = RingCamera(30, 70);
  other.camera.name = "another";
  WriteCameraFile(camera_, other);
  const std::string second = folder_ / "4712.png", before = ReadFile(out_ + "/interior.csv");
  fs::copy(scan_, second);
  std::vector<std::string> arguments = Arguments(second);
  const ProgramRun refused = RunOrient(arguments);
  EXPECT_EQ(refused.exit_code, 1) << refused.err;
  EXPECT_NE(refused.err.find("interior.csv"), std::string::npos) << refused.err;
  EXPECT_EQ(ReadFile(out_ + "/interior.csv"), before);
  arguments.emplace_back("--overwrite");
  EXPECT_EQ(RunOrient(arguments).exit_code, 0);
}

TEST_F(InteriorCommandTest, APictureThatCannotBeWrittenDoesNotCostTheTransform) {
  fs::create_directories(out_ + "/4711.marks.png/in the way");
  EXPECT_EQ(RunOrient(Arguments(scan_)).exit_code, 0);
  const InteriorResult result = ReadInteriorResult(InteriorResultPath(out_, "4711"));
  EXPECT_EQ(result.status, Status::kOk);
  EXPECT_TRUE(std::any_of(result.findings.begin(), result.findings.end(),
                          [](const Finding& f) { return f.reason == Reason::kPictureNotWritten; }));
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
  EXPECT_NE(Sentence(failed.findings.at(0)).find("broken.png"), std::string::npos);
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
