// Film deformation remaining after an affine transform, as a grid of corrections over the scan:
// photo = A pixel + t + correction(pixel).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/transform2d.h"

namespace orient {

// Bilinear between nodes; beyond the grid the nearest place of its border counts.
struct FilmCorrection {
  Eigen::Vector2d origin_px = Eigen::Vector2d::Zero();  // of the first node
  Eigen::Vector2d step_px = Eigen::Vector2d::Ones();
  int columns = 0, rows = 0;                   // nodes, at least two each
  std::vector<Eigen::Vector2d> correction_mm;  // row by row, in the photo system

  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const;
};

// Both directions between scan and photo system; a null correction is none. The inverse solves for
// the pixel by iteration: a film's correction changes slowly.
Eigen::Vector2d PhotoFromPixel(const Affine2d& photo_from_pixel, const FilmCorrection* correction,
                               const Eigen::Vector2d& pixel);
Eigen::Vector2d PixelFromPhoto(const Affine2d& photo_from_pixel, const FilmCorrection* correction,
                               const Eigen::Vector2d& photo_mm);

}  // namespace orient
