// Interior orientation of one photo: search range, candidates, assignment, subpixel, transform.
//
// A result is `ok` only where chance could not have produced it; `weak` and `failed` say why in
// their messages.
#pragma once

#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/imaging/raster.h"
#include "interior/locator.h"
#include "interior/mark_drawing.h"

namespace orient {

// What the scanner does to the film: next to nothing, or scales that differ by up to 2.5 % and
// bends of a tenth of a millimetre (desktop scanners, contact prints).
enum class Scanner { kPhotogrammetric, kDesktop };

struct InteriorOptions {
  std::optional<double> pixel_size_um;  // empty: the tag, else from the marks (JudgePixelSize)
  std::optional<Polarity> polarity;     // empty: found out
  std::optional<ScanOrientation> orientation;     // empty: found out or left open
  std::optional<Scanner> scanner = std::nullopt;  // empty: found out
  // Empty: by the drawing's kind (UsualLocator).
  std::optional<LocatorKind> locator = std::nullopt;
};

// `shapes` holds the drawing of every mark the camera's fiducials name (see ShapesOf). The photo's
// name is left to the caller. Throws InputError where the scan is damaged, and for a camera of kind
// film without fiducials. `nats`, where it is given, becomes the log odds of the marks found
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

}  // namespace orient
