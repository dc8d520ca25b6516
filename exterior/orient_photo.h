// Exterior orientation of one photo: predict, align, match, resect, again.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"
#include "exterior/steps/photo_image.h"
#include "exterior/steps/photo_to_orient.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

// `patches` are those under the uncertain footprint (of the widened prior for a wide search). The
// result is `ok`, `weak` or `failed` with the reason; a pose is given unless it failed.
ExteriorResult OrientPhoto(const PhotoToOrient& photo, const PhotoImage& image,
                           const std::vector<patchdb::Patch>& patches,
                           const OrientPhotoOptions& options = {});

}  // namespace orient::exterior
