// A small block to export: two photos of a large digital camera.
#pragma once

#include <vector>

#include "tools/convert/convert_source.h"
#include "tools/convert/write_exports.h"

namespace orient {

inline Camera LargeFrameCamera() {
  Camera camera;
  camera.name = "large frame";
  camera.kind = CameraKind::kDigital;
  camera.principal_distance_mm = 100.5;
  camera.principal_point_mm = {0.12, -0.08};
  camera.frame_mm = {103.86, 67.824};
  camera.image_px = Eigen::Vector2i(14425, 9420);
  camera.lens = BrownDistortion{{1.2e-8, -3e-13, 1e-17}, {2e-7, -1e-7}};
  return camera;
}

inline ConvertSource TwoPhotos() {
  ConvertSource source;
  source.cameras = {LargeFrameCamera()};
  source.block.cameras = {ExchangeCameraOf(source.cameras[0]).camera};
  source.crs = Crs::Parse("EPSG:32635", "test");
  source.block.crs = source.crs->Wkt();
  const auto add = [&](const char* image, const Eigen::Vector3d& at, const Eigen::Vector3d& deg) {
    ExchangePhoto photo;
    photo.image = image;
    SetPose({at, deg * RadFromDeg(1)}, &photo);
    source.block.photos.push_back(photo);
    source.ground_height_m.emplace_back(300);
  };
  add("4711.tif", {500123.4, 5000321, 3823.9}, {0.12, -0.3, 91.2});
  add("4712.tif", {501123.4, 5000421, 3830.9}, {2.82, 4.3, -38.2});
  source.block.points = {
      {"17", true, {500100, 5000300, 310}, {{0, {7000, 4500}}, {1, {6000, 4000}}}}};
  return source;
}

inline std::vector<ExchangeFormat> AllFormats() {
  return {kAllExchangeFormats.begin(), kAllExchangeFormats.end()};
}

}  // namespace orient
