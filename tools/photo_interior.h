// Where a photo's pixels lie on the film or sensor: what every stage after the interior one needs.
#pragma once

#include <string>

#include "core/geometry/camera.h"
#include "core/geometry/transform2d.h"
#include "core/imaging/raster.h"

namespace orient {

// A digital camera's fixed transform, or the interior orientation that `orient interior` left in
// `interior_directory`. Throws InputError naming the photo and what to do: an image of another size
// than the camera's or the oriented scan's, no interior orientation, a failed one.
Affine2d PhotoFromPixelOf(const Raster& photo, const Camera& camera,
                          const std::string& interior_directory);

}  // namespace orient
