// How a film may lie on its scan, and how well that is known: from interior to exterior
// orientation.
#pragma once

#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "exterior/orient_photo.h"
#include "interior/marks/mark_drawing.h"

namespace orient::block {

// One position, or those that interior orientation left open; the likeliest first. The result must
// have a transform.
std::vector<exterior::FilmPosition> FilmPositions(const InteriorResult& result,
                                                  const CameraFile& camera,
                                                  const interior::MarkShapes& marks);

}  // namespace orient::block
