// A small block with one photo of each status, for tests of what is made from results.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <string>
#include <utility>

#include "core/files/camera_file.h"
#include "core/files/orientation_table.h"
#include "core/files/results.h"
#include "tests/support/example_adjustment.h"

namespace orient {

inline PatchResult ExamplePatch(std::int64_t id, PatchState state, const Eigen::Vector2d& pixel,
                                const Eigen::Vector2d& residual_px) {
  PatchResult patch;
  patch.id = id;
  patch.state = state;
  // A vertical photo of 0.5 m pixels around (500000, 5000000): col to the east, row to the south.
  patch.ground_m =
      Eigen::Vector3d(500000 + 0.5 * (pixel.x() - 1000), 5000000 - 0.5 * (pixel.y() - 1000), 400);
  patch.predicted = pixel;
  if (state == PatchState::kNotFound || state == PatchState::kNotVisible) return patch;
  patch.pixel = pixel;
  patch.sigma_px = Eigen::Vector2d(0.08, 0.07);
  patch.residual_px = residual_px;
  patch.ncc = 0.87;
  return patch;
}

inline ExteriorResult ExampleExterior(const std::string& photo, Status status) {
  ExteriorResult result;
  result.photo = photo;
  result.status = status;
  result.width = result.height = 2000;
  result.iterations = {{26, 9, 412.0, 1.9}, {26, 20, 40.0, 0.35}};
  if (status == Status::kFailed) {
    result.findings = {{.reason = Reason::kStated, .where = "only 3 patches agree on a pose"}};
    return result;
  }
  result.pose = Pose{{500000.25, 5000000.5, 1823.75}, {0.01, -0.02, 1.5}};
  Matrix6d covariance = Matrix6d::Identity() * 1e-8;
  covariance.topLeftCorner<3, 3>() = Eigen::Matrix3d::Identity() * 0.16;
  result.covariance = covariance;
  StartingPose start{*result.pose, Vector6d::Constant(std::numbers::pi)};
  start.pose.position_m += Eigen::Vector3d(-12.5, 4, status == Status::kOk ? 0 : 2);
  result.approximation = start;
  result.sigma0_px = 0.31;
  result.projection_sigma = ProjectionSigma{0.42, 0.21};
  for (const auto& [x, y] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}, {-1, -1}})
    result.footprint_m.push_back({500000.0 + 500 * x, 5000000.0 + 500 * y, 400});
  result.patches = {ExamplePatch(11, PatchState::kMatched, {200, 300}, {0.5, 0.0}),
                    ExamplePatch(12, PatchState::kMatched, {1700, 400}, {0.0, -0.25}),
                    ExamplePatch(13, PatchState::kMatched, {900, 1800}, {-0.2, 0.1}),
                    ExamplePatch(14, PatchState::kRejected, {1000, 1000}, {9.0, 4.0}),
                    ExamplePatch(15, PatchState::kNotFound, {400, 1500}, {0, 0}),
                    ExamplePatch(16, PatchState::kNotVisible, {2600, 1500}, {0, 0})};
  result.patches[3].findings = {{.reason = Reason::kPatchContradictsOthers}};
  if (status == Status::kWeak)
    result.findings = {{.reason = Reason::kStated, .where = "the matches leave the tilt open"}};
  return result;
}

inline InteriorResult ExampleInterior(const std::string& photo) {
  InteriorResult result;
  result.photo = photo;
  result.status = Status::kOk;
  result.width = result.height = 2000;
  result.photo_from_pixel = Affine2d{Eigen::Vector2d(0.025, -0.025).asDiagonal(), {-25, 25}};
  result.orientation = ScanOrientation::kR0;
  result.polarity = Polarity::kPositive;
  result.sigma0_um = 4.1;
  result.margin = 9.3;
  MarkResult used{"1",
                  MarkState::kUsed,
                  Eigen::Vector2d(312.41, 288.07),
                  Eigen::Vector2d(0.02, 0.02),
                  Eigen::Vector2d(1.1, -0.4),
                  0.93};
  MarkResult missing;
  missing.id = "2";
  result.marks = {used, missing};
  return result;
}

// Photos 4711 (ok), 4712 (weak) and 4713 (failed) with orientation.csv and .prj in EPSG:32635.
inline void WriteExampleBlock(const std::string& directory) {
  OrientationTable table;
  table.crs = Crs::Parse("EPSG:32635", "example");
  for (const auto& [photo, status] :
       {std::pair{"4711", Status::kOk}, {"4712", Status::kWeak}, {"4713", Status::kFailed}}) {
    const ExteriorResult exterior = ExampleExterior(photo, status);
    WriteInteriorResult(directory, ExampleInterior(photo));
    WriteExteriorResult(directory, exterior);
    if (exterior.pose) table.rows.push_back({photo, *exterior.pose, std::nullopt});
  }
  WriteOrientationTable(directory + "/orientation.csv", table);
}

// The digital camera that the block's poses hold with: 100 mm, 50 mm x 50 mm.
inline void WriteExampleCamera(const std::string& directory) {
  CameraFile camera;
  camera.camera.name = "an <old> camera";
  camera.camera.kind = CameraKind::kDigital;
  camera.camera.principal_distance_mm = 100;
  camera.camera.frame_mm = {50, 50};
  camera.camera.image_px = Eigen::Vector2i(2000, 2000);
  WriteCameraFile(directory + "/block_camera.toml", camera);
}

}  // namespace orient
