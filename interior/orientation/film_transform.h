// The film's transform from measured marks: similarity, then affine; marks that the others
// contradict are rejected; the rest must be a plausible film.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/transform2d.h"

namespace orient::interior {

struct MeasuredMark {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d photo_mm = Eigen::Vector2d::Zero();  // calibrated
};

// Scanner and film parameters from one photo's affine, invariant to rotating, mirroring and
// shifting the film.
struct FilmShape {
  double column_um = 0, row_um = 0;  // pixel size along the scan's columns axis, and along rows
  double scale_difference = 0;       // (column - row) / mean
  double shear_rad = 0;              // the scan's axes' angle less 90 degrees
};
FilmShape ShapeOf(const Affine2d& photo_from_pixel);

struct FilmTransform {
  Affine2d photo_from_pixel;
  bool affine = false;                       // false: by three marks, which leave no redundancy
  std::vector<Eigen::Vector2d> residual_um;  // of every mark: calibrated - photo_from_pixel * pixel
  double sigma0_um = 0;                      // sqrt(v'v / (2n - 6)); 0 with three marks
  double similarity_rms_um = 0;              // what a similarity leaves
  double pixel_um = 0;                       // sqrt(|det A|)
  FilmShape shape;
};

// Affine for four marks or more; similarity (`mirrored` or not) for three, but the affine through
// them where a similarity leaves more than 0.3 mm. Empty below three, and
// where the marks lie on one line: their spread (root mean square, photo system) across it is less
// than a twentieth of that along it, and measuring noise would decide the transform.
std::optional<FilmTransform> FitFilm(const std::vector<MeasuredMark>& marks, bool mirrored);

}  // namespace orient::interior
