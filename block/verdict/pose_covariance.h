// The joint covariance of all poses of a block, errors common to neighbours included.
#pragma once

#include <string>
#include <vector>

#include "block/stages/adjustment_stage.h"

namespace orient::block {

std::string PoseCovariancePath(const std::string& directory);

// Of the photos whose pose in `results` (as the inputs' photos) is the block's. Header, then a row
// an element (x, y, z [m], omega, phi, kappa [rad]) of each photo, with as many columns. Removes an
// earlier run's file where it is not wanted, or the adjustment gave none: false where it is wanted.
// Throws InputError: cannot write.
bool WritePoseCovariance(const std::string& directory, bool wanted, const AdjustedBlock& adjusted,
                         const std::vector<ExteriorResult>& results);

// Where it is wanted, and there is none.
Finding NoPoseCovariance();

}  // namespace orient::block
