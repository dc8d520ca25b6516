// The block adjustment between files: what goes in from the photos' results, ties and the patch
// database, and what each photo's final result is.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/geometry/ground_surface.h"
#include "exterior/block_adjustment.h"
#include "tools/block/block_photos.h"
#include "tools/block/pose_observations.h"
#include "tools/block/tie_file.h"

namespace orient {

struct AdjustmentInputs {
  const std::vector<BlockPhotoFile>& photos;
  const std::vector<TieRecord>& ties;
  const Camera& camera;
  const GroundSurface& surface;
  std::string patchdb;
  BlockAdjustmentChoice choice;
  PoseObservations known = {};
};

// What was adjusted and what came out; indices of `block` go through `photo_of` to those of the
// inputs' photos.
struct AdjustedBlock {
  BlockToAdjust block;
  BlockResult result;
  std::vector<std::size_t> photo_of;
  std::size_t ties = 0;                       // the first so many points are ties
  std::map<std::int64_t, std::size_t> patch;  // point of a control patch
  // Sightings of check patches that their photo's own orientation had told for gross errors, so
  // that they are not among the checks.
  int checks_rejected_alone = 0;
};

// Throws InputError where the patch database cannot be read.
AdjustedBlock AdjustPhotos(const AdjustmentInputs& inputs);

// `results` are those of an adjustment with GNSS and approximations as observations, `without`
// those of one without: a photo is no better than the photos and control alone make it.
void HoldToControl(const std::vector<ExteriorResult>& without,
                   std::vector<ExteriorResult>* results);
// Where the adjustment without them gave nothing: no photo is ok.
void HoldAllToControl(std::vector<ExteriorResult>* results);

// One result a photo, as the inputs' photos: the adjusted pose with its covariance where it may be
// trusted, otherwise the photo's own, otherwise failed with the reason.
std::vector<ExteriorResult> FinalResults(const AdjustmentInputs& inputs,
                                         const AdjustedBlock& adjusted);

// Where nothing is adjusted: every photo's own result; what rests on neighbours only has failed.
std::vector<ExteriorResult> OwnResults(const std::vector<BlockPhotoFile>& photos);

}  // namespace orient
