// How finely film was scanned, known before interior orientation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"

namespace orient::block {

// Side of a scan's pixel on the film, mm: frame size over scan size, so too small by the margins of
// the scan, and too large for a scan that does not hold the whole frame.
// The median over some of the scans. Empty: the camera is digital, or none of the scans can be
// opened.
std::optional<double> FilmPixel_mm(const Camera& camera, const std::vector<std::string>& scans);

}  // namespace orient::block
