#include "tools/block_camera.h"

#include <filesystem>

#include "core/error.h"

namespace orient {
namespace fs = std::filesystem;

namespace {
constexpr const char* kFileName = "block_camera.toml";
}

std::string BlockCameraPath(const std::string& directory) {
  return (fs::path(directory) / kFileName).string();
}

void WriteBlockCamera(const std::string& directory, const CameraFile& camera, double earth_k1) {
  CameraFile to = camera;
  if (earth_k1 != 0) to.camera.name += ", with earth curvature and refraction in the lens";
  WriteCameraFile(BlockCameraPath(directory), to);
}

void RefuseBlockCamera(const std::string& camera, EarthMode earth) {
  if (earth == EarthMode::kFlat || fs::path(camera).filename() != kFileName) return;
  throw UsageError(
      camera +
      " belongs to poses: curvature and refraction are in its lens already and would "
      "be added again; give the camera's own file (or calibrated_camera.toml), or this "
      "one with --earth flat (earth = \"flat\" in a block file)");
}

}  // namespace orient
