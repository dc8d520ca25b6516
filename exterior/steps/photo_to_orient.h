// What is given for one photo's exterior orientation: the photo, what is known of it, and options.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/camera.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/resection.h"
#include "core/terrain/ground_surface.h"
#include "exterior/steps/visibility.h"

namespace orient::exterior {

// One possible scan orientation of the film.
struct FilmPosition {
  Affine2d photo_from_pixel;
  std::optional<ScanOrientation> orientation;  // none for digital photos
  // Of photo_from_pixel (a11 a12 a21 a22 t1 t2; mm); zero for digital photos.
  Matrix6d covariance = Matrix6d::Zero();
  double film_sigma_mm = 0;  // of its smooth deformation between the marks; zero for digital photos
  std::shared_ptr<const FilmCorrection> film_correction = nullptr;  // where a reseau shows it
};

struct PhotoToOrient {
  std::string name;
  Camera camera;
  std::vector<FilmPosition> positions;  // one, or those that interior orientation left open
  PosePrior prior;                      // the approximation and its accuracy
  // Whether that accuracy was stated. A pose that contradicts it is then only weak: the patches'
  // coordinates may be wrong.
  bool accuracy_is_stated = true;
  std::vector<CoveredArea> covered = {};   // parts of the frame that show no ground
  const GroundSurface* surface = nullptr;  // the terrain, which may hide patches; null: none does
};

// Sides of an aligned patch, pixels of the resolution at which it is searched for.
inline constexpr int kMinSide_px = 15;
inline constexpr int kMaxSide_px = 61;

struct OrientPhotoOptions {
  double max_log10_false_alarms = -6;
  // Searched at every kappa and beyond the stated accuracy (search/wide_search.h), not in windows
  // around the patches (search/first_pose.h).
  bool wide = false;
  // Accuracy on the ground, one sigma anywhere in the frame, that makes the photo ok; otherwise a
  // pixel of the photo, or half a pixel of the patches where these are coarser.
  std::optional<double> target_m;
  // With `wide`: the search within the stated accuracy found nothing; it may be wrong.
  bool prior_failed = false;
};

}  // namespace orient::exterior
