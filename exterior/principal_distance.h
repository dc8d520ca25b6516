// The loop for a photo whose principal distance is not trusted: orient, free it, orient again.
#pragma once

#include <vector>

#include "exterior/orient_photo.h"

namespace orient::exterior {

// From a photo that was oriented with the camera as it is (`first`, of the same photo, patches and
// options): pose, covariance and principal distance estimated together, and the patches matched
// again under them until it settles. The camera's principal distance is known to `sigma_mm` before.
// Messages say what it is and where the photo does not tell it. `weak` where it does not settle.
// Where nothing can be estimated: `first`, at best `weak`.
ExteriorResult OrientWithPrincipalDistance(const PhotoToOrient& photo, const PhotoImage& image,
                                           const std::vector<patchdb::Patch>& patches,
                                           const OrientPhotoOptions& options,
                                           const ExteriorResult& first, double sigma_mm);

}  // namespace orient::exterior
