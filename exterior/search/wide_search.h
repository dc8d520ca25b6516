// The first round where the approximation is too poor for a search window around each patch: the
// whole photo is searched, at every kappa and several scales, for tiles of the mosaic that the
// patches make together, and the tiles vote. Private to exterior.
#pragma once

#include <optional>

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

// Not searched where the patches make no mosaic that could be searched for, and the photo is too
// large to be searched for single ones. The caller asks whether chance explains the pose; every
// hypothesis tried is counted in.
WholePhotoSearch SearchWidely(const PhotoTask& task);

}  // namespace orient::exterior
