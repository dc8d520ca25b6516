// The jobs of the tie points: one per photo, each written as soon as it is done.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "block/inputs/block_photos.h"
#include "block/stages/result_store.h"
#include "block/ties/tie_file.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

struct TieStage {
  const std::vector<BlockPhotoFile>& photos;
  const Camera& camera;
  const GroundSurface& surface;
  Inputs inputs;  // what all photos share: camera, DEM
  ResultStore store;
  int jobs = 0;
};

// Ties of all photos that have a pose and a neighbour; those that are there and current are kept.
// An image that cannot be read any more leaves its photo without ties and is reported in
// `*findings`. `done` is called once per photo, from one thread at a time.
std::vector<TieRecord> RunTieStage(const TieStage& stage, const std::function<void()>& done,
                                   Findings* findings);

}  // namespace orient::block
