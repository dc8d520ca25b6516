// The first round where the approximation is too poor for a search window around each patch: the
// whole photo is searched, at every kappa and several scales, for tiles of the mosaic that the
// patches make together, and the tiles vote. Private to exterior.
#pragma once

#include <optional>

#include "exterior/steps/photo_task.h"

namespace orient::exterior {

// Empty where the patches make no mosaic that could be searched for, or nothing in the photo is
// like it. The caller asks whether chance explains the pose; every hypothesis tried is counted in.
std::optional<PoseTrack> SearchWidely(const PhotoTask& task);

}  // namespace orient::exterior
