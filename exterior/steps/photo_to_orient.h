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

struct OrientPhotoOptions {
  int voting_patches = 160;   // in the coarse rounds
  int precise_patches = 900;  // at full resolution
  int max_precise_rounds = 5;
  int min_side_px = 15;  // of an aligned patch at a coarse level
  int max_side_px = 61;  // and at full resolution
  double max_log10_false_alarms = -6;
  int min_matched = 6;                    // fewer are never accepted
  int weak_matched = 12;                  // fewer places do not determine its precision: weak
  double weak_projection_sigma_px = 1.0;  // a worse-determined pose is weak
  // Share of the photo over which the matched patches spread; a pose of fewer is weak.
  double weak_spread = 0.03;
  // The whole photo is searched at every kappa and several scales, whatever the approximation says.
  bool wide = false;
};

}  // namespace orient::exterior
