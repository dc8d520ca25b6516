// How a photo lies on its scan, for exterior orientation: a digital photo's by its camera, a film's
// by the results of `orient interior`.
#pragma once

#include <string>
#include <vector>

#include "core/files/camera_file.h"
#include "core/imaging/raster.h"
#include "exterior/orient_photo.h"
#include "interior/interior.h"

namespace orient {

// How the film lies on the scan, and whether its polarity is negative.
struct ScanInterior {
  std::vector<FilmPosition> positions;
  bool negative = false;
  std::vector<std::string> messages;
  bool weak = false;
  std::string failure;  // not empty: no orientation
};

// What of the frame shows no ground: the fiducial marks with their symbols, and the clocks,
// counters and unexposed parts that the camera file knows (its `border`).
std::vector<CoveredArea> CoveredAreas(const CameraFile& camera, const MarkShapes& marks);

ScanInterior DigitalGeometry(const Camera& camera, const Raster& raster);

// From a result of interior orientation. Throws InputError where it cannot be read.
ScanInterior FilmGeometry(const CameraFile& camera, const MarkShapes& marks, const Raster& scan,
                          const std::string& path);

}  // namespace orient
