// The cameras that the simulator flies.
#pragma once

#include "core/files/camera_file.h"
#include "tools/simulate/simulation_options.h"

namespace orient::simulation {

struct SimulatedCamera {
  CameraFile file;
  double pixel_size_mm = 0.025;
  double film_half_mm = 0;  // the film's edge; 0 for a digital camera
  int width_px = 0, height_px = 0;
  std::optional<Camera> over_earth = std::nullopt;  // with curvature and refraction; absent: flat

  const Camera& Seeing() const { return over_earth ? *over_earth : file.camera; }
};

SimulatedCamera NewCamera(const SimulationOptions& options);
// Flies old_height_ratio times as high with a longer lens; pixels of old_gsd_ratio.
SimulatedCamera OldCamera(const SimulationOptions& options);

// Metres of flat ground under a photo's principal distance: the height above ground at which the
// camera's pixel covers `gsd_m`.
double FlyingHeight(const SimulatedCamera& camera, double gsd_m);

}  // namespace orient::simulation
