#include "block/verdict/calibrated_camera.h"

#include <algorithm>
#include <filesystem>

#include "block/inputs/block_files.h"
#include "core/terrain/earth_effects.h"

namespace orient::block {
namespace fs = std::filesystem;

std::string CalibratedCameraPath(const std::string& directory) {
  return (fs::path(directory) / kCalibratedCameraFile).string();
}

void WriteCalibratedCamera(const std::string& directory, const CameraFile& camera,
                           const BlockResult& result) {
  const std::string path = CalibratedCameraPath(directory);
  const bool calibrated =
      result.converged && std::any_of(result.calibration.begin(), result.calibration.end(),
                                      [](const CalibrationParameter& parameter) {
                                        return parameter.state == CalibrationState::kEstimated;
                                      });
  if (!calibrated || result.cameras.empty()) {
    std::error_code ignored;
    fs::remove(path, ignored);
    return;
  }
  CameraFile to = camera;
  to.camera = WithEarth(result.cameras.front(), -result.cameras.front().earth_k1);
  WriteCameraFile(path, to);
}

}  // namespace orient::block
