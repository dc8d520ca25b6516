// `orient block` on image measurements alone, as a user runs it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "block/block_folder.h"
#include "block/inputs/block_files.h"
#include "core/base/atomic_write.h"
#include "core/base/folder_lock.h"
#include "core/base/output_directory.h"
#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/geometry/collinearity.h"
#include "core/measurements/written_measurements.h"
#include "core/terrain/photo_view.h"
#include "tests/support/run_orient.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kPixel_mm = 0.01, kSeen_px = 0.2, kTrueDistance_mm = 70;

// Three photos over mountains with many surveyed points; the camera file's principal distance is
// wrong by half a millimetre.
class MeasuredBlock : public testing::Test {
 protected:
  void SetUp() override {
    camera_.camera.name = "made up";
    camera_.camera.kind = CameraKind::kDigital;
    camera_.camera.principal_distance_mm = kTrueDistance_mm;
    camera_.camera.frame_mm = {60, 60};
    camera_.camera.image_px = {6000, 6000};
    for (int i = 0; i < 8; ++i)
      for (int j = 0; j < 8; ++j)
        measured_.points.push_back(
            {fmt::format("p{}", 8 * i + j),
             {499500.0 + 220 * i, 5599500.0 + 140 * j, 300.0 + 80 * ((3 * i + 5 * j) % 6)},
             Eigen::Vector3d::Constant(0.02),
             PointRole::kControl});
    See("a", {{499900, 5600000, 1700}, {0.02, -0.01, 0.1}});
    See("b", {{500300, 5600000, 1720}, {-0.02, 0.02, 1.6}});
    See("c", {{500700, 5600000, 1690}, {0.01, 0.01, 3.1}});
    CameraFile wrong = camera_;
    wrong.camera.principal_distance_mm += 0.5;
    WriteCameraFile(folder_ / "camera.toml", wrong);
    WriteImagePoints(folder_.Path(), measured_.image_points);
    WritePoints(folder_.Path(), measured_.points);
    WriteFileAtomically(folder_ / "block.toml",
                        "crs = \"EPSG:32635\"\ncamera = \"camera.toml\"\nmeasurements = \".\"\n"
                        "earth = \"flat\"\n[block]\nself_calibration = \"camera\"\n"
                        "pose_covariance = true\n");
  }

  void See(const std::string& photo, const Pose& pose) {
    for (const GroundPoint& point : measured_.points) {
      const auto mm = PhotoFromGround(camera_.camera, pose, point.ground_m);
      if (!mm || mm->cwiseAbs().maxCoeff() > 29) continue;
      const Eigen::Vector2d pixel(3000 + mm->x() / kPixel_mm + kSeen_px * normal_(random_),
                                  3000 - mm->y() / kPixel_mm + kSeen_px * normal_(random_));
      measured_.image_points.push_back({photo, point.name, pixel, std::nullopt, kSeen_px, {}});
    }
  }
  ProgramRun Run(std::vector<std::string> more = {}) const {
    more.insert(more.begin(), {"block", folder_ / "block.toml"});
    return RunOrient(more);
  }
  std::string Out(const std::string& file) const { return folder_ / ("out/" + file); }
  bool Exists(const std::string& file) const { return fs::exists(Out(file)); }

  TemporaryFolder folder_;
  CameraFile camera_;
  Measurements measured_;
  std::mt19937 random_{3};
  std::normal_distribution<double> normal_;
};

TEST_F(MeasuredBlock, LeavesWhatABlockOfPhotosLeaves) {
  const ProgramRun run = Run();
  ASSERT_EQ(run.exit_code, 0) << run.out << run.err;
  for (const char* file :
       {"a.exterior.json", "orientation.csv", "block.json", "block.gpkg", "block.qgz",
        "report.html", "run.json", "control_points.csv", "pose_covariance.csv"})
    EXPECT_TRUE(Exists(file)) << file;
  EXPECT_FALSE(block::IsUnfinished(Out("")));
}

TEST_F(MeasuredBlock, ItsCameraIsTheCalibratedOneWithWhichThePosesHold) {
  ASSERT_EQ(Run().exit_code, 0);
  const double calibrated = ReadCameraFile(Out("block_camera.toml")).camera.principal_distance_mm;
  EXPECT_NEAR(calibrated, kTrueDistance_mm, 0.1);
  EXPECT_EQ(calibrated, ReadCameraFile(Out("calibrated_camera.toml")).camera.principal_distance_mm);
  const Camera camera = ReadCameraFile(Out("block_camera.toml")).camera;
  PhotoView view{camera, DigitalPhotoFromPixel(camera), {}};
  for (const ImagePointMeasurement& seen : measured_.image_points) {
    view.pose = *ReadExteriorResult(Out(seen.photo + ".exterior.json")).pose;
    const auto pixel = view.PixelFromGround(measured_.Point(seen.point)->ground_m);
    EXPECT_LT((*pixel - *seen.pixel).norm(), 8 * kSeen_px) << seen.photo << " " << seen.point;
  }
}

TEST_F(MeasuredBlock, APlanWritesNothing) {
  const ProgramRun run = Run({"--plan"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("64 ground points"), std::string::npos) << run.out;
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(MeasuredBlock, WhatCannotBeAdjustedIsSaidBeforeAnythingIsWritten) {
  WriteImagePoints(folder_.Path(), {});
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--plan"}}) {
    const ProgramRun run = Run(more);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_NE(run.err.find("holds no image points"), std::string::npos) << run.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }
}

TEST_F(MeasuredBlock, ResultsOfScansAreSetAside) {
  MakeOutputDirectory(Out(""));
  WriteFileAtomically(Out("a.interior.json"), "of the scan");
  ASSERT_EQ(Run().exit_code, 0);
  EXPECT_FALSE(Exists("a.interior.json"));
  EXPECT_EQ(ReadFile(Out("not_in_block/a.interior.json")), "of the scan");
  EXPECT_TRUE(Exists("a.exterior.json"));
}

TEST_F(MeasuredBlock, OptionsOfPhotosAreRefused) {
  for (const char* option : {"--learn", "--quicklook", "--status"}) {
    EXPECT_EQ(Run({option}).exit_code, 1) << option;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }
}

TEST_F(MeasuredBlock, ReplacesNothingUnlessAsked) {
  MakeOutputDirectory(Out(""));
  WriteFileAtomically(Out("a.exterior.json"), "of another run");
  EXPECT_EQ(Run().exit_code, 1);
  EXPECT_EQ(ReadFile(Out("a.exterior.json")), "of another run");
  EXPECT_FALSE(Exists("b.exterior.json"));
}

TEST_F(MeasuredBlock, RemovesWhatNoLongerHolds) {
  ASSERT_EQ(Run().exit_code, 0);
  std::string text = ReadFile(folder_ / "block.toml");
  text.replace(text.find("pose_covariance = true"), 22, "pose_covariance = false");
  WriteFileAtomically(folder_ / "block.toml", text);
  ASSERT_EQ(Run({"--overwrite"}).exit_code, 0);
  EXPECT_FALSE(Exists("pose_covariance.csv"));
}

TEST_F(MeasuredBlock, TwoRunsDoNotWriteIntoOneFolder) {
  MakeOutputDirectory(Out(""));
  const FolderLock other(Out(""), block::kBlockLock);
  const ProgramRun run = Run();
  EXPECT_EQ(run.exit_code, 2) << run.out << run.err;
  EXPECT_FALSE(Exists("orientation.csv"));
}

}  // namespace
}  // namespace orient
