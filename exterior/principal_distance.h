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

// Residuals with a trend may be a wrong principal distance's, with a pose that has followed it
// where the patches are and nowhere else. Estimated with next to no prior: where it differs from
// the camera's by more than four of its sigmas, a finding says so, `weak` where the pose it belongs
// to projects ground in the frame farther from there than three of the stated sigmas.
void JudgePrincipalDistance(const PhotoToOrient& photo, const std::vector<patchdb::Patch>& patches,
                            ExteriorResult* result);

}  // namespace orient::exterior
