// What the approximations of a run's photos have in common against their poses.
#pragma once

#include <optional>
#include <vector>

#include "core/files/results.h"

namespace orient::block {

// Where they lie beside the poses all by the same: each of them may be within its accuracy, all of
// them together are not. Then approximations and control are of different datums, ellipsoidal and
// orthometric heights, say, and which of them is wrong nothing here tells. Of at least three photos
// with a pose; their mean difference in x, y or z must be five of its standard deviations (by the
// stated ones, or by their scatter where that is larger) and 1.5 of a single photo's stated ones.
std::optional<Finding> ApproximationsApart(const std::vector<ExteriorResult>& results);

}  // namespace orient::block
