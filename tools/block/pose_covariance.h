// The covariance of all poses of a block together: what neighbours err in common is in it.
#pragma once

#include <string>

#include "tools/block/adjustment_stage.h"

namespace orient {

std::string PoseCovariancePath(const std::string& directory);

// pose_covariance.csv: a header, then a row an element (x, y, z [m], omega, phi, kappa [rad]) of
// every adjusted photo, with as many columns. Removes an earlier run's where it is not wanted, or
// the adjustment gave none: false where it is wanted. Throws InputError: cannot write.
bool WritePoseCovariance(const std::string& directory, bool wanted, const AdjustedBlock& adjusted);

}  // namespace orient
