// How the patches that a photo was oriented by alone fit its pose in the block. Private to block.
#pragma once

#include "core/files/results.h"

namespace orient::block {

struct OwnPatches {
  int used = 0;
  int contradicting = 0;  // the block: it rejects them, the photo alone did not
  double rms_px = 0;      // residuals of those used, one coordinate
};

// Of patches with their states and residuals in the block.
OwnPatches OwnPatchesOf(const std::vector<PatchResult>& patches);

// Whether the photo's ties, or the sources of its neighbours' patches, hold it off the place where
// its own patches put it: these fit 2.5 times worse than alone (`sigma0_px`), by 0.2 px at least.
// Never of fewer than 30.
bool IsHeldOff(const OwnPatches& patches, double sigma0_px);

}  // namespace orient::block
