#include "block/inputs/block_camera.h"

#include <filesystem>

#include "core/base/error.h"

namespace orient::block {
namespace fs = std::filesystem;

std::string BlockCameraPath(const std::string& directory) {
  return (fs::path(directory) / "block_camera.toml").string();
}

void WriteBlockCamera(const std::string& directory, const CameraFile& camera) {
  WriteCameraFile(BlockCameraPath(directory), camera);
}

void RefuseBlockCamera(const std::string& camera, EarthMode earth) {
  if (earth == EarthMode::kFlat || ReadCameraFile(camera).camera.earth_k1 == 0) return;
  throw UsageError(
      camera +
      " was written with poses: curvature and refraction are in its lens already and would "
      "be added again; give the camera's own file (or calibrated_camera.toml), or this "
      "one with --earth flat (earth = \"flat\" in a block file)");
}

std::optional<std::string> OtherBlockCamera(const std::string& directory,
                                            const std::string& camera) {
  const std::string own = BlockCameraPath(directory);
  std::error_code ignored;
  if (!fs::exists(own, ignored) ||
      CameraFileText(ReadCameraFile(own), "/") == CameraFileText(ReadCameraFile(camera), "/"))
    return std::nullopt;
  return own;
}

void RequireCameraOfPoses(const std::string& camera, const std::string& table) {
  if (const auto own = OtherBlockCamera(fs::path(table).parent_path().string(), camera))
    throw UsageError("the poses of " + table + " are valid with " + *own +
                     " (calibration, curvature and refraction are in its lens), not with " +
                     camera + "; give --camera " + *own + " --earth flat");
}

}  // namespace orient::block
