// How the patches that a photo was oriented by alone fit its pose in the block. Private to block.
#pragma once

#include <vector>

#include "core/files/results.h"

namespace orient::block {

struct OwnPatches {
  int used = 0;  // alone and in the block
  // The photo alone used them, the block rejects them; and of these those that lie beside the pose
  // by no more than three times the RMS distance of those used: the tail of a common misfit, where
  // the others may be gross errors by themselves.
  int rejected = 0, misfitting = 0;
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
