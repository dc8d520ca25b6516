// How finely film was scanned, known before interior orientation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"

namespace orient::block {

// Side of a scan's pixel on the film, mm: the frame's sides spread over the scan's, so at most the
// true one, by as much as the scan has margins; of a scan that does not hold the whole frame more.
// The middle one of some of the scans. Empty: the camera is digital, or none of the scans can be
// opened.
std::optional<double> FilmPixel_mm(const Camera& camera, const std::vector<std::string>& scans);

}  // namespace orient::block
