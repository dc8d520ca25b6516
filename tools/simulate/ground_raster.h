// The simulated ground at one date as two rasters in memory: how bright it is, with light and
// shadow, and how high the things on it stand above the bare ground.
#pragma once

#include <cstdint>
#include <vector>

#include "core/terrain/ground_surface.h"
#include "tools/simulate/scene.h"
#include "tools/simulate/terrain.h"

namespace orient::simulation {

struct GroundRaster {
  double west = 0, north = 0;  // outer corner of the upper-left cell, block CRS
  double cell = 0;             // m
  int width = 0, height = 0;
  std::vector<std::uint16_t> tone;       // 65535: a tone of 1
  std::vector<std::uint16_t> object_cm;  // height above the bare ground
  int tile = 32;                         // cells a side of an entry of tallest_cm
  int tiles_across = 0;
  std::vector<std::uint16_t> tallest_cm;  // of each tile

  // Tone at a position, bilinear between cell centres, 0 to 1; the nearest beyond the edge.
  float ToneAt(double x, double y) const;
  // Height of what stands at a position (the cell it lies in), m; 0 beyond the edge.
  float ObjectAt(double x, double y) const;
  // Nothing within `reach_m` of a position stands higher than this, m.
  float TallestNear(double x, double y, double reach_m) const;

  Bounds Extent() const { return {west, north - height * cell, west + width * cell, north}; }
};

// Renders `extent` (within the scene's) in cells of `cell_m`, in parallel.
GroundRaster RenderGround(const Scene& scene, const Terrain& terrain, Epoch epoch,
                          const Bounds& extent, double cell_m);

}  // namespace orient::simulation
