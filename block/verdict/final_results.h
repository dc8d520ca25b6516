// What the block adjustment makes of each photo: accepted, kept as it was alone, or failed.
#pragma once

#include <vector>

#include "block/stages/adjustment_stage.h"
#include "core/files/results.h"

namespace orient::block {

// One result a photo, as the inputs' photos: the adjusted pose with its covariance where it may be
// trusted, otherwise the photo's own, otherwise failed with the reason.
std::vector<ExteriorResult> FinalResults(const AdjustmentInputs& inputs,
                                         const AdjustedBlock& adjusted);

// Where nothing is adjusted: every photo's own result; what rests on neighbours only has failed.
std::vector<ExteriorResult> OwnResults(const std::vector<BlockPhotoFile>& photos);

// `results` are those of an adjustment with GNSS and approximations as observations, `without`
// those of one without: a photo is no better than the photos and control alone make it.
void HoldToControl(const std::vector<ExteriorResult>& without,
                   std::vector<ExteriorResult>* results);
// Where the adjustment without them gave nothing: no photo is ok.
void HoldAllToControl(std::vector<ExteriorResult>* results);

}  // namespace orient::block
