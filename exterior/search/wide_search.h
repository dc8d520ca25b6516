// The first round where the approximation is too poor for a search window around each patch: its
// keypoints are compared with the patches' (keypoint_search.h). Where they show no pose and the
// approximation is not believed, the whole photo is searched, at every kappa and several scales,
// for tiles of the mosaic that the patches make together, and the tiles vote. Last, where the
// position is known, every patch is searched for in a window of its own, kappa by kappa
// (first_pose.h), or if all windows are too large, for tiles as well. Private to exterior.
#pragma once

#include <optional>

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

// Not searched from below the ground, nor where neither keypoints nor tiles nor single patches can
// be searched for. The caller asks whether chance explains the pose; every hypothesis of all
// searches is counted in, tried or not.
WholePhotoSearch SearchWidely(const PhotoTask& task);

}  // namespace orient::exterior
