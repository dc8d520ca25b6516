// What the page is told, as JSON.
#pragma once

#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/measurements/measurements.h"
#include "tools/review/review_state.h"
#include "tools/review/scan_tiles.h"

namespace orient {

// Of the list: photos in the order in which to look at them, with status, reasons, what was said,
// whether it is done. `scans`: which of them can be shown.
std::string ListJson(const ReviewState& state, const Measurements& measurements,
                     const std::string& version, const std::string& undo, const ScanTiles& scans);

// A scan for the viewer: its size, or why it cannot be shown.
struct ShownScan {
  std::optional<ScanSize> size;
  std::string why_not;
};

// Of one photo: marks, patches and ties with pixels and residuals (pixels), and what was said of
// it. Of a photo with a film transform also, where the camera is known (else null): pixels at which
// its marks are expected, and the frame's outline.
std::string PhotoJson(const ReviewState& state, const Measurements& measurements,
                      const PhotoRecord& photo, const ShownScan& scan, const CameraFile* camera);

// An orthophoto under the map, north up: x = x0 + step col, y = y0 - step row.
struct MapGround {
  ScanSize size;
  double x0 = 0, y0 = 0, step_x = 1, step_y = 1;
};

// Of the map: centres, footprints, ground points.
std::string MapJson(const ReviewState& state, const Measurements& measurements,
                    const std::optional<MapGround>& ground);

}  // namespace orient
