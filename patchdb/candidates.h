// Interest points of a whole source, tile by tile, sorted into a grid over the ground.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/imaging/raster.h"
#include "patchdb/source_view.h"

namespace orient {

struct InterestCandidate {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // of the source
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  double weight = 0;  // Foerstner's
  double roundness = 0;
};

// Cell (row, col): row 0 begins at Y = 0 and counts southwards, col counts eastwards from X = 0.
// The grid belongs to the ground, so that neighbouring sources share it.
using CellIndex = std::pair<std::int64_t, std::int64_t>;

struct CandidateGrid {
  std::map<CellIndex, std::vector<InterestCandidate>> cells;  // each strongest first
  int count = 0;                                              // of all candidates found
};

// Keeps the `per_cell` strongest candidates of each cell of cell_m metres. Never reads more than a
// tile (and its border) of the raster at once; `progress` hears of (tiles done, tiles in all).
CandidateGrid FindInterestCandidates(const Raster& raster, const SourceView& source, double cell_m,
                                     int per_cell, int tile_px,
                                     const std::function<void(int, int)>& progress = {});

}  // namespace orient
