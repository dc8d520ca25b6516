// Photos of an adjusted block as maps between ground and scan.
#pragma once

#include <cstddef>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"
#include "core/terrain/photo_view.h"

namespace orient::block {

// An adjusted photo as a map between ground and scan: pose, calibrated camera, corrected film.
PhotoView AdjustedView(const BlockToAdjust& block, const BlockResult& result, std::size_t photo);

}  // namespace orient::block
