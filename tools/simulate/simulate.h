// Makes a small photo block whose truth is known exactly: ground, two dates, old oriented photos
// from which patches are harvested, and new film scans to orient. Everything derives from the seed.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tools/simulate/simulation_options.h"

namespace orient {

struct SimulationSummary {
  std::vector<std::string> photos;      // paths of the new scans
  std::vector<std::string> old_photos;  // paths of the old photos
  std::string block_file;
  std::string truth_file;
  int width = 0, height = 0;   // of a new scan, px
  double flying_height_m = 0;  // above the ground's mean height
  int parcels = 0, buildings = 0, trees = 0;
};

// Writes into `out_dir` (made where it is absent):
//   block.toml camera.toml approx.csv dem.tif change.tif scans/*.tif
//   old/camera.toml old/orientation.csv old/photos/*.tif old/interior/*.json [old/ortho.tif]
//   truth.json truth/orientation.csv truth/interior/*.json truth/standing.tif
// truth.json comes last: where it is, the block is whole. `step` is told how many
// of how many steps are done (a step: the ground of a date, a photo), first with 0 done.
// Throws UsageError: wrong options, or a folder that is not empty without `overwrite`; a folder
// that no simulation made is never emptied. Throws InputError: cannot write.
SimulationSummary Simulate(const SimulationOptions& options, const std::string& out_dir,
                           const std::function<void(int done, int steps)>& step = {});

}  // namespace orient
