#include "block/verdict/calibrated_camera.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "block/inputs/block_camera.h"
#include "tests/support/example_camera.h"
#include "tests/support/shared_data.h"

namespace orient::block {
namespace {

BlockResult Calibrated(const Camera& camera) {
  BlockResult result;
  result.converged = true;
  result.cameras = {camera};
  CalibrationParameter k1;
  k1.name = "k1";
  k1.state = CalibrationState::kEstimated;
  result.calibration = {k1};
  return result;
}

double K1(const std::string& path) {
  return std::get<BrownDistortion>(ReadCameraFile(path).camera.lens).k[0];
}

// Curvature belongs to the flight: the next block adds its own.
TEST(CalibratedCamera, IsWithoutCurvatureAndTheBlocksCameraWithIt) {
  const TemporaryFolder folder;
  constexpr double kEarth = -7e-9, kLens = 3e-8;
  CameraFile file = ExampleCamera();
  file.camera.lens = BrownDistortion{{kLens, 0, 0}, {0, 0}};
  file.camera = WithEarth(file.camera, kEarth);
  WriteCalibratedCamera(folder.Path(), file, Calibrated(file.camera));
  WriteBlockCamera(folder.Path(), file);
  EXPECT_NEAR(K1(CalibratedCameraPath(folder.Path())), kLens, 1e-15);
  EXPECT_NEAR(K1(BlockCameraPath(folder.Path())), kLens + kEarth, 1e-15);
  EXPECT_EQ(ReadCameraFile(CalibratedCameraPath(folder.Path())).camera.earth_k1, 0);
  EXPECT_EQ(ReadCameraFile(BlockCameraPath(folder.Path())).camera.earth_k1, kEarth);
}

TEST(CalibratedCamera, OfNothingEstimatedGoes) {
  const TemporaryFolder folder;
  const CameraFile file = ExampleCamera();
  WriteCalibratedCamera(folder.Path(), file, Calibrated(file.camera));
  BlockResult nothing = Calibrated(file.camera);
  nothing.calibration[0].state = CalibrationState::kInsignificant;
  WriteCalibratedCamera(folder.Path(), file, nothing);
  EXPECT_FALSE(std::filesystem::exists(CalibratedCameraPath(folder.Path())));
}

}  // namespace
}  // namespace orient::block
