// How the patches that a photo was oriented by alone fit its pose in the block. Private to block.
#pragma once

#include <vector>

#include "core/files/results.h"

namespace orient::block {

struct OwnPatches {
  int used = 0;           // alone and in the block
  int contradicting = 0;  // the block: it rejects them, the photo alone did not
  // Residuals of those used, one coordinate. Edges, which are matched across only, are not in them.
  double alone_rms_px = 0, rms_px = 0;
};

// Of patches with their states and residuals, `alone` and in the `block`.
OwnPatches OwnPatchesOf(const std::vector<PatchResult>& alone,
                        const std::vector<PatchResult>& block);

// Whether the photo's ties, or the sources of its neighbours' patches, hold it off the place where
// its own patches put it: these fit 2.5 times worse than alone, by 0.2 px at least. Never of fewer
// than 30.
bool IsHeldOff(const OwnPatches& patches);

}  // namespace orient::block
