// Where the photos of a simulated block are taken from, and what ground they need.
#pragma once

#include <string>
#include <vector>

#include "core/geometry/pose.h"
#include "core/terrain/ground_surface.h"
#include "tools/simulate/cameras.h"
#include "tools/simulate/noise.h"

namespace orient::simulation {

struct PlannedPhoto {
  std::string name;
  Pose pose;
};

struct BlockLayout {
  std::vector<PlannedPhoto> fresh;  // the new photos
  std::vector<PlannedPhoto> old;
  double mean_height_m = 250;
  Bounds ground;  // that the DEM must cover, errors of the approximations included
};

BlockLayout PlanBlock(const SimulationOptions& options, const SimulatedCamera& fresh,
                      const SimulatedCamera& old);

// Box around the ground in the photos' frames, where the ground lies no lower than `low_m`.
Bounds FootprintBounds(const Camera& camera, const std::vector<PlannedPhoto>& photos, double low_m);

}  // namespace orient::simulation
