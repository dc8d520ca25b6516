// The asymmetry of the film's border: the data strip's side and what else the camera file says that
// only one place of the border shows. (Schickler 1995 tells the eight scan orientations apart by
// it.)
#pragma once

#include <vector>

#include "core/files/camera_file.h"
#include "interior/marks/film_tone.h"

namespace orient::interior {

// A part of the border, or where a scan orientation would have it.
struct BorderPlace {
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();  // photo axes of the orientation assumed
  Eigen::Vector2d high_mm = Eigen::Vector2d::Zero();
};

enum class SignSeen { kYes, kNo, kUnclear };

// Does a place show the sign? Unclear where too little of it lies on the scan, or where there is
// neither what the sign promises nor what should be there without it. `marks_mm`: fiducial marks
// and their symbols are no writing.
SignSeen LookFor(BorderSign sign, const BorderPlace& place, const Raster& scan,
                 const Affine2d& pixel_from_photo, const FilmTone& tone,
                 const std::vector<Eigen::Vector2d>& marks_mm);

// The camera file's features, the data strip as the rectangle beside its side of the frame.
std::vector<BorderFeature> BorderFeatures(const CameraFile& camera);

// Log-likelihood, nats, of each scan orientation, given what is seen at all places of a feature:
// places[o] is the index into `seen` of the place where way o has it.
std::vector<double> NatsOfFeature(BorderSign sign, const std::vector<SignSeen>& seen,
                                  const std::vector<size_t>& places);

}  // namespace orient::interior
