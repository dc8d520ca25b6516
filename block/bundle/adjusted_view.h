// Photos of an adjusted block as maps between ground and scan.
#pragma once

#include <cstddef>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"
#include "core/terrain/photo_view.h"

namespace orient::block {

// An adjusted photo as a map between ground and scan: pose, calibrated camera, corrected film.
PhotoView AdjustedView(const BlockToAdjust& block, const BlockResult& result, std::size_t photo);

// The same with the film transform as given, which is what files of results have: the adjustment
// moves it within its covariance. The pose is that with which it shows level ground at `height_m`
// where the adjusted photo does.
PhotoView ViewWithGivenFilm(const BlockToAdjust& block, const BlockResult& result,
                            std::size_t photo, double height_m);

}  // namespace orient::block
