// What a simulated camera sees: every pixel's ray cut with the ground and what stands on it.
#pragma once

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/raster/image.h"
#include "tools/simulate/ground_raster.h"
#include "tools/simulate/scan_geometry.h"
#include "tools/simulate/terrain.h"

namespace orient::simulation {

// A ray from the projection centre as metres east and north per metre of descent.
struct RaySlope {
  double east = 0, north = 0;
};

// Where a ray from `centre` meets the bare ground (bilinear surface; exact to a millimetre).
// `start_height`: a guess. Needs ground flatter than the ray is steep; Simulate() checks that.
Eigen::Vector3d MeetGround(const Terrain& terrain, const Eigen::Vector3d& centre,
                           const RaySlope& slope, double start_height);

// The scene's tone (0 to 1, with the lens's fall-off) in every pixel of the scan that lies within
// the camera's frame or `margin_mm` of it; 0 elsewhere. Averages over the pixel's area.
Image RenderPhoto(const Camera& camera, const Pose& pose, const ScanGeometry& scan,
                  const GroundRaster& ground, const Terrain& terrain, double margin_mm);

}  // namespace orient::simulation
