// Photos that their own patches could not orient, oriented by patches cut from neighbours that are:
// a first pose for ties, never control.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "block/inputs/block_approximations.h"
#include "block/inputs/block_photos.h"
#include "block/stages/exterior_stage.h"
#include "core/base/progress.h"
#include "core/terrain/ground_surface.h"

namespace orient::block {

struct NeighbourStage {
  ExteriorRunOptions exterior;  // of the photos' own stage; photos, out and resume are set here
  BlockApproximations& approximations;  // learns from each round's poses
  const CameraFile& camera;
  const interior::MarkShapes& marks;
  const GroundSurface& surface;
  std::string interior_directory;
  std::string directory;  // a folder per round below it
  ProgressListener* listener = nullptr;
};

// Rounds: patches of all photos with a pose are offered to all photos without one that have a new
// neighbour, until none is left to try. Those whose approximations come from strips are tried as
// these become known (BlockApproximations::Next). Those that are left then, and those of which
// nothing is known, are tried where keypoints that they share with oriented photos say that they
// lie (keypoint_stage.h); the patches alone accept. Results of earlier runs are kept where what
// they were made from is the same. `*photos` take over the poses; those that stay failed keep their
// own result. What stops a round is reported in `*findings`.
void RunNeighbourStage(const NeighbourStage& stage, std::vector<BlockPhotoFile>* photos,
                       Findings* findings);

}  // namespace orient::block
