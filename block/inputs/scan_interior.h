// How a photo lies on its scan, for exterior orientation: a digital photo's by its camera, a film's
// by the results of `orient interior`.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"
#include "exterior/orient_photo.h"
#include "interior/interior.h"

namespace orient::block {

// How the film lies on the scan, and whether its polarity is negative.
struct ScanInterior {
  std::vector<exterior::FilmPosition> positions;
  bool negative = false;
  Findings
      findings;  // what the interior orientation says against the photo; failed: no orientation
};

// What of the frame shows no ground: the fiducial marks with their symbols, and the clocks,
// counters and unexposed parts that the camera file knows (its `border`).
std::vector<exterior::CoveredArea> CoveredAreas(const CameraFile& camera,
                                                const interior::MarkShapes& marks);

ScanInterior DigitalGeometry(const Camera& camera, const Raster& raster);

// From a result of interior orientation. Throws InputError where it cannot be read.
ScanInterior FilmGeometry(const CameraFile& camera, const interior::MarkShapes& marks,
                          const Raster& scan, const std::string& path);

}  // namespace orient::block
