// Orientation with the principal distance as an additional unknown.
#pragma once

#include <vector>

#include "exterior/orient_photo.h"

namespace orient::exterior {

// From a photo that was oriented with the camera as it is (`first`, of the same photo, patches and
// options): pose, covariance and principal distance estimated together, and the patches matched
// again with them until it converges. `sigma_mm`: prior sigma of the camera's principal distance.
// Messages give its value, and say if the photo does not determine it. `weak` if it does not
// converge. Where nothing can be estimated: `first`, at best `weak`.
ExteriorResult OrientWithPrincipalDistance(const PhotoToOrient& photo, const PhotoImage& image,
                                           const std::vector<patchdb::Patch>& patches,
                                           const OrientPhotoOptions& options,
                                           const ExteriorResult& first, double sigma_mm);

// A trend in the residuals may be due to a wrong principal distance that the pose compensates for
// only where there are patches. It is estimated almost without prior. If it differs from the
// camera's by more than four of its sigmas, a finding says so: `weak` if the pose estimated with it
// displaces projected ground points in the frame by more than three stated projection sigmas.
void JudgePrincipalDistance(const PhotoToOrient& photo, const std::vector<patchdb::Patch>& patches,
                            ExteriorResult* result);

}  // namespace orient::exterior
