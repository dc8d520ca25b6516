// Draws buildings, trees and their shadows into a band of the ground raster.
#pragma once

#include <cstdint>
#include <vector>

#include "tools/simulate/scene.h"

namespace orient::simulation {

// Rows of the ground raster being drawn. Positions: metres from the scene's south-west corner.
struct GroundBand {
  float west = 0;   // outer edge of column 0
  float north = 0;  // outer edge of row 0
  float cell = 0;
  int width = 0, height = 0;
  std::vector<float> tone;      // row-major
  std::vector<float> object_m;  // height above the bare ground
};

// Darkens the ground in the shadows of everything that stands at that date.
void DrawShadows(const Scene& scene, Epoch epoch, GroundBand* band);

// Roofs and crowns over the ground, the higher over the lower.
void DrawObjects(const Scene& scene, Epoch epoch, GroundBand* band);

}  // namespace orient::simulation
