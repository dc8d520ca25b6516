#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <random>
#include <sstream>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "tests/support/film_frame.h"
#include "tests/support/shared_data.h"
#include "tools/commands/commands.h"

namespace orient {
namespace {

using Eigen::Vector2d;

struct Outcome {
  int code = -1;
  std::string out, err;
};

Outcome Orient(const std::vector<std::string>& arguments) {
  CommandList commands;
  commands.push_back(MakeInteriorCommand());
  std::ostringstream out, err;
  Outcome outcome;
  outcome.code = RunProgram(commands, arguments, out, err);
  outcome.out = out.str();
  outcome.err = err.str();
  return outcome;
}

// A camera of eight marks whose first mark lies 80 um to the right of where its file says.
class EstimateCameraTest : public testing::Test {
 protected:
  EstimateCameraTest() {
    camera_ = RingCamera(106, 230);
    for (const Vector2d& p :
         {Vector2d(-110, 0), Vector2d(110, 0), Vector2d(0, 110), Vector2d(0, -110)})
      camera_.fiducials.push_back(
          {std::to_string(camera_.fiducials.size() + 1), p, "corner", std::nullopt});
    WriteCameraFile(start_, camera_);
  }

  // Results as `orient interior` writes them, of film lying turned by 90 degrees.
  void WriteResults(int photos, double scale_difference, const std::string& other_id = "") {
    std::mt19937 random(4);
    std::normal_distribution<double> normal;
    for (int i = 0; i < photos; ++i) {
      InteriorResult result;
      result.photo = std::to_string(i);
      result.status = Status::kOk;
      result.photo_from_pixel =
          Affine2d{0.025 * PhotoFromPixelAxes(ScanOrientation::kR90), {-115.0, 115.0}};
      result.possible_orientations = {ScanOrientation::kR90};
      const Affine2d pixel_from_photo = result.photo_from_pixel->Inverse();
      for (const Fiducial& f : camera_.fiducials) {
        Vector2d place = f.position_mm;
        if (f.id == "1") place.x() += 0.080;
        place += 0.002 * Vector2d(normal(random), normal(random));
        place.x() *= 1 + scale_difference;
        MarkResult mark;
        mark.id = f.id;
        mark.state = MarkState::kUsed;
        mark.pixel = pixel_from_photo * place;
        result.marks.push_back(mark);
      }
      if (!other_id.empty()) result.marks.back().id = other_id;
      WriteInteriorResult(folder_.Path(), result);
    }
  }

  Outcome Estimate(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "interior", "estimate-camera", folder_.Path(), "--camera", start_, "--out", out_};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Orient(arguments);
  }

  // The first mark's place relative to the mean of all, which the start file fixes.
  static double MovedX(const CameraFile& a, const CameraFile& b) {
    double first = a.fiducials[0].position_mm.x() - b.fiducials[0].position_mm.x();
    for (size_t i = 1; i < a.fiducials.size(); ++i)
      first -= (a.fiducials[i].position_mm.x() - b.fiducials[i].position_mm.x()) / 7;
    return first;
  }

  TemporaryFolder folder_;
  CameraFile camera_;
  std::string start_ = folder_ / "start.toml", out_ = folder_ / "estimated.toml";
};

TEST_F(EstimateCameraTest, AWrongPositionIsPutRightWithItsPrecision) {
  WriteResults(20, 0);
  const Outcome outcome = Estimate();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("photogrammetric"), std::string::npos) << outcome.out;
  const CameraFile estimated = ReadCameraFile(out_);
  ASSERT_EQ(estimated.fiducials.size(), 8U);
  EXPECT_GT(MovedX(estimated, camera_), 0.050) << "most of the 80 um; turn and scale share some";
  for (const Fiducial& f : estimated.fiducials) {
    ASSERT_TRUE(f.sigma_mm);
    EXPECT_LT(f.sigma_mm->maxCoeff(), 0.03);
  }
  EXPECT_EQ(Estimate().code, 1) << "never overwrites";
  EXPECT_EQ(Estimate({"--overwrite"}).code, 0);
  EXPECT_EQ(Orient({"interior", "estimate-camera", folder_.Path(), "--camera", start_, "--out",
                    start_, "--overwrite"})
                .code,
            1)
      << "never replaces the start file";
}

TEST_F(EstimateCameraTest, ADesktopScannersAffinityIsSaidToBeUnknown) {
  WriteResults(20, 0.01);
  const Outcome outcome = Estimate();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("cannot be separated"), std::string::npos) << outcome.out;
  EXPECT_GT(MovedX(ReadCameraFile(out_), camera_), 0.02);
  for (const Fiducial& f : ReadCameraFile(out_).fiducials)
    EXPECT_LT(f.sigma_mm->maxCoeff(), 0.002) << "no scanner's affinity in it";
}

TEST_F(EstimateCameraTest, TooFewScansOrMarksOfAnotherCameraAreBadInput) {
  WriteResults(2, 0);
  const Outcome few = Estimate();
  EXPECT_EQ(few.code, 2);
  EXPECT_NE(few.err.find("at least three"), std::string::npos) << few.err;
  WriteResults(5, 0, "elsewhere");
  const Outcome other = Estimate();
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("\"elsewhere\""), std::string::npos) << other.err;
  EXPECT_EQ(Orient({"interior", "estimate-camera", folder_ / "nowhere", "--camera", start_, "--out",
                    out_})
                .code,
            2);
}

TEST_F(EstimateCameraTest, ItsOwnOptionsAreRequiredAndThoseOfInteriorAreNot) {
  EXPECT_EQ(Orient({"interior", "estimate-camera", folder_.Path(), "--out", out_}).code, 1);
  EXPECT_EQ(Orient({"interior", "--camera", start_}).code, 1) << "PHOTO is still required there";
}

}  // namespace
}  // namespace orient
