// A digital camera without distortion, for tests that change it.
#pragma once

#include "core/files/camera_file.h"

namespace orient {

inline CameraFile ExampleCamera() {
  CameraFile file;
  file.camera.name = "example";
  file.camera.kind = CameraKind::kDigital;
  file.camera.principal_distance_mm = 100;
  file.camera.frame_mm = Eigen::Vector2d(40, 30);
  file.camera.image_px = Eigen::Vector2i(4000, 3000);
  return file;
}

}  // namespace orient
