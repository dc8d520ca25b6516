// Bundle block adjustment: poses of all photos and ground points at once, from the observations of
// ties and control, with their precision. Pure: plain values in, plain values out.
//
// Robust start, then data snooping with local redundancies (Baarda 1968), variance components per
// group (Foerstner 1979, simplified), self-calibration with significance tests. Ceres solves
// (Triggs et al. 2000: Schur complement); covariances come from a sparse inverse of the reduced
// normal equations (Takahashi et al. 1973).
#pragma once

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"

namespace orient::block {

// Throws std::invalid_argument for indices out of range and invalid covariances.
BlockResult AdjustBlock(const BlockToAdjust& block, const BlockOptions& options = {});

}  // namespace orient::block
