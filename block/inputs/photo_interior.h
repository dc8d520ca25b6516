// Where a photo's pixels lie on the film or sensor: what every stage after the interior one needs.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/transform2d.h"
#include "core/raster/raster.h"

namespace orient::block {

struct PhotoInterior {
  Affine2d photo_from_pixel;
  std::shared_ptr<const FilmCorrection> film_correction = nullptr;  // where a reseau shows it
};

// A digital camera's fixed transform, or the interior orientation that `orient interior` left in
// `interior_directory`. Throws InputError naming the photo and what to do: an image of another size
// than the camera's or the oriented scan's, no interior orientation, a failed one.
PhotoInterior PhotoInteriorOf(const Raster& photo, const Camera& camera,
                              const std::string& interior_directory);

// The same of a photo whose scan orientation the exterior orientation may have found: `orientation`
// is asked where the marks leave it open. Throws InputError, too, where the marks exclude it.
PhotoInterior PhotoInteriorOf(const Raster& photo, const CameraFile& camera,
                              const std::string& interior_directory,
                              const std::function<std::optional<ScanOrientation>()>& orientation);

// Throws InputError where `photo` is of another size than the camera's images, or not the scan
// whose interior orientation is in the folder.
void RequireOrientedScan(const Raster& photo, const Camera& camera,
                         const std::string& interior_directory);

// Why `scan` (of that size) is not the one whose interior orientation `path` holds, and what to do;
// empty where it is. Scans of one size are distinguished by their content, where the result says of
// which it was made.
std::string WhyOfAnotherScan(const InteriorResult& interior, const std::string& path,
                             const std::string& scan, int width, int height);

// The result's film correction; null where it has none.
std::shared_ptr<const FilmCorrection> CorrectionOf(const InteriorResult& interior);

}  // namespace orient::block
