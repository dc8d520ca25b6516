// Common shift of a block's approximations against its poses. Private to block.
#pragma once

#include <optional>
#include <vector>

#include "block/inputs/pose_observations.h"
#include "core/files/results.h"

namespace orient::block {

// If they all differ from the poses by the same shift: each may be within its accuracy, but all of
// them together are not. Then approximations and control are of different datums, ellipsoidal and
// orthometric heights, say, and nothing here tells which of them is wrong. Of at least three photos
// with a pose whose approximation's accuracy is `stated`; their mean difference in x, y or z must
// be five of its standard deviations (by the stated ones, or by their scatter where that is larger,
// and by the poses' own, which may be common to all) and 1.5 of a single difference's.
std::optional<Finding> ApproximationsApart(const std::vector<ExteriorResult>& results,
                                           const PosePriors& stated);

// The same finding of each of these photos, which is at best weak.
void AddToPhotos(const Finding& apart, const PosePriors& stated,
                 std::vector<ExteriorResult>* results);

}  // namespace orient::block
