#include "tools/block/calibrated_camera.h"

#include <algorithm>
#include <filesystem>

#include "core/geometry/earth_effects.h"
#include "tools/block_files.h"

namespace orient {
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

}  // namespace orient
