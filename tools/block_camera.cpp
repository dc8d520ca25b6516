#include "tools/block_camera.h"

#include <filesystem>
#include <string_view>

#include "core/error.h"

namespace orient {
namespace fs = std::filesystem;

namespace {

constexpr const char* kFileName = "block_camera.toml";
// Of a camera's name, which its copies beside exports and resampled images keep.
constexpr std::string_view kWithEarth = ", with earth curvature and refraction in the lens";

bool HoldsTheEarth(const std::string& camera) {
  return fs::path(camera).filename() == kFileName ||
         ReadCameraFile(camera).camera.name.ends_with(kWithEarth);
}

}  // namespace

std::string BlockCameraPath(const std::string& directory) {
  return (fs::path(directory) / kFileName).string();
}

void WriteBlockCamera(const std::string& directory, const CameraFile& camera, double earth_k1) {
  CameraFile to = camera;
  if (earth_k1 != 0) to.camera.name += kWithEarth;
  WriteCameraFile(BlockCameraPath(directory), to);
}

void RefuseBlockCamera(const std::string& camera, EarthMode earth) {
  if (earth == EarthMode::kFlat || !HoldsTheEarth(camera)) return;
  throw UsageError(
      camera +
      " belongs to poses: curvature and refraction are in its lens already and would "
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
    throw UsageError("the poses of " + table + " are true with " + *own +
                     " (calibration, curvature and refraction are in its lens), not with " +
                     camera + "; give --camera " + *own + " --earth flat");
}

}  // namespace orient
