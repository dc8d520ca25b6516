// Where a simulated film lies on the scanner and how it has shrunk: the exact map between a scan's
// pixels and the photo system. Written from the words of the conventions and not with
// core/geometry's PhotoFromPixelAxes, so that the simulator's truth is an independent one.
#pragma once

#include <Eigen/Core>

#include "core/geometry/transform2d.h"

namespace orient::simulation {

struct ScanSetup {
  int width = 0, height = 0;
  double pixel_size_mm = 0.025;
  ScanOrientation orientation = ScanOrientation::kR0;
  double rotation_rad = 0;  // further counter-clockwise turn of the film as seen in the scan
  Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  // of the film's centre, to the right and up
  // photo = stretch * film + bend(film): the calibrated position of what lies at a place of the
  // shrunken film. bend: mm for the terms u2 uv v2 u3 u2v uv2 v3 of film / half_frame_mm.
  Eigen::Matrix2d stretch = Eigen::Matrix2d::Identity();
  Eigen::Matrix<double, 2, 7> bend = Eigen::Matrix<double, 2, 7>::Zero();
  double half_frame_mm = 1;
};

// Whether the film's columns run along the scan's rows.
bool LiesAcross(ScanOrientation orientation);

class ScanGeometry {
 public:
  explicit ScanGeometry(const ScanSetup& setup);

  Eigen::Vector2d PhotoFromPixel(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d PixelFromPhoto(const Eigen::Vector2d& photo_mm) const;

  // The best affine photo_from_pixel over the frame, and how far the exact map departs from it
  // (root mean square of the vector, mm).
  Affine2d BestAffine() const { return affine_; }
  double BendRms() const { return bend_rms_mm_; }

  const ScanSetup& Setup() const { return setup_; }

 private:
  ScanSetup setup_;
  Eigen::Matrix2d film_from_scan_;  // turns and mirrors mm of the scan back
  Affine2d affine_;
  double bend_rms_mm_ = 0;
};

// Random coefficients that bend a film by `rms_um` (root mean square of the vector over the frame,
// after the best affine transform).
Eigen::Matrix<double, 2, 7> RandomBend(double half_frame_mm, double rms_um, std::uint64_t seed);

}  // namespace orient::simulation
