// truth.json: everything that is known exactly about a simulated block.
#pragma once

#include <string>
#include <vector>

#include "tools/simulate/photo_making.h"
#include "tools/simulate/scene.h"

namespace orient::simulation {

struct BlockTruth {
  const SimulationOptions& options;
  const Scene& scene;
  const Terrain& terrain;
  const SimulatedCamera& fresh_camera;
  const SimulatedCamera& old_camera;
  const std::vector<PhotoPlan>& fresh;
  const std::vector<PhotoPlan>& old;
};

// Points of the ground on a regular grid over the new photos, away from buildings and trees.
std::vector<Eigen::Vector3d> CheckPoints(const BlockTruth& truth);

// Fields: docs/simulate.md.
void WriteTruth(const std::string& path, const BlockTruth& truth);

// A mask of the ground: 1 where a parcel changed its look, 2 where a building came or went, else 0.
void WriteChangeMask(const std::string& path, const BlockTruth& truth, const Crs& crs);

// Likewise: 1 where at either date something stands, leans in a photo or casts its shadow.
void WriteStandingMask(const std::string& path, const BlockTruth& truth, const Crs& crs);

}  // namespace orient::simulation
