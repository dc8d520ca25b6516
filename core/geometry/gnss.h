// GNSS observations of projection centres, and their systematic errors per strip.
#pragma once

#include <Eigen/Core>

namespace orient {

struct GnssPosition {
  Eigen::Vector3d position_m;  // lever arm already applied
  Eigen::Matrix3d covariance_m2;
  double along_strip = 0;  // -1 at the strip's first exposure, 1 at its last: argument of the drift
};

enum class GnssModel { kPlain, kShift, kShiftAndDrift };  // unknowns per strip

}  // namespace orient
