// Interest points of a whole source, tile by tile, sorted into a grid over the ground.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "core/raster/raster.h"
#include "patchdb/harvest/source_view.h"

namespace orient::patchdb {

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

struct CandidateSearch {
  double cell_m = 0;
  int per_cell = 4;   // the strongest are kept
  int tile_px = 512;  // of the reduced raster
  // Raster pixels per pixel of the image that points are searched for in: where few are wanted,
  // those that survive the pyramid's first levels are seen there, in a fraction of the time.
  int reduction = 1;
  // Points elsewhere do not count; called from several threads. Empty: all count.
  std::function<bool(const Eigen::Vector3d& ground_m)> wanted;
};

// Never holds more than a few tiles (and their borders) of the raster at once. The same whatever
// the number of threads. `progress` hears of (tiles done, tiles in all).
CandidateGrid FindInterestCandidates(const Raster& raster, const SourceView& source,
                                     const CandidateSearch& search,
                                     const std::function<void(int, int)>& progress = {});

CellIndex CellOf(const Eigen::Vector2d& ground_m, double cell_m);

}  // namespace orient::patchdb
