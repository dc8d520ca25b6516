// Whether the heights of DEM and patches refer to the same place and datum.
#pragma once

#include <vector>

#include "core/files/results.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/store/patch.h"

namespace orient::block {

// Compares the heights of the matched patches with the DEM's. Where they differ by more than their
// uncertainty and `tolerance_m` allow, the photo is at best weak and its findings say by how much:
// a pose from patches of another place or height datum fits them as well as the right one.
void CheckHeights(const GroundSurface& dem, const std::vector<patchdb::Patch>& patches,
                  double tolerance_m, ExteriorResult* result);

}  // namespace orient::block
