// The jobs of the tie points: one a photo, each written as soon as it is done.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/geometry/ground_surface.h"
#include "tools/block/block_photos.h"
#include "tools/block/stage_folder.h"
#include "tools/block/tie_file.h"

namespace orient {

struct TieStage {
  const std::vector<BlockPhotoFile>& photos;
  const Camera& camera;
  const GroundSurface& surface;
  std::string inputs;  // digest of what all photos share: camera, DEM
  StageFolder folder;
  int jobs = 0;
};

// Ties of all photos that have a pose and a neighbour; those that are there and current are kept.
// An image that cannot be read any more leaves its photo without ties and is told in `messages`.
// `done` is called once a photo, from several threads.
std::vector<TieRecord> RunTieStage(const TieStage& stage, const std::function<void()>& done,
                                   std::vector<std::string>* messages);

}  // namespace orient
