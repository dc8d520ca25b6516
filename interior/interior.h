// Interior orientation of one photo: search range, candidates, assignment, subpixel, transform.
//
// A result is `ok` only where chance could not have produced it; `weak` and `failed` say why in
// their messages.
#pragma once

#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "interior/constellation/interior_options.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {

// `shapes` holds the drawing of every mark the camera's fiducials name (see ShapesOf). The photo's
// name is left to the caller. Throws InputError where the scan is damaged, and for a camera of kind
// film without fiducials. `nats`, where it is given, becomes the log odds of the marks used
// against clutter (0 for a digital camera): what several cameras are compared by.
InteriorResult OrientInterior(const Raster& scan, const CameraFile& camera,
                              const MarkShapes& shapes, const InteriorOptions& options = {},
                              double* nats = nullptr);

// The camera's drawings; pictures they refer to are handed in by name of the mark.
MarkShapes ShapesOf(const CameraFile& camera, const std::map<std::string, Image>& pictures = {});

// The same measured marks read as if the film lay in `orientation`: marks change their names and
// the affine is estimated anew. The first possibility and the only one are then `orientation`.
// Empty where the marks exclude it (it is none of result.possible_orientations) or the result has
// no transform.
std::optional<InteriorResult> InOrientation(const InteriorResult& result, const CameraFile& camera,
                                            const MarkShapes& shapes, ScanOrientation orientation);

}  // namespace orient::interior
