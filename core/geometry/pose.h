// The exterior orientation of a photo: projection centre and rotation, in ground coordinates.
#pragma once

#include <Eigen/Core>

#include "core/geometry/rotation.h"

namespace orient {

// Order of the six elements wherever they stand in one vector or matrix:
// x y z [m] omega phi kappa [rad].
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

struct Pose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  // projection centre, ground
  Eigen::Vector3d opk_rad = Eigen::Vector3d::Zero();     // omega, phi, kappa

  Eigen::Matrix3d GroundFromPhoto() const { return GroundFromPhotoRotation(opk_rad); }
  Vector6d AsVector() const { return (Vector6d() << position_m, opk_rad).finished(); }
  static Pose FromVector(const Vector6d& v) { return {v.head<3>(), v.tail<3>()}; }
};

// Difference `to` - `from`; those of angles are reduced to (-pi, pi].
inline Vector6d PoseDifference(const Pose& to, const Pose& from) {
  Vector6d difference = to.AsVector() - from.AsVector();
  for (int i = 3; i < 6; ++i) difference[i] = NormalizeAngle(difference[i]);
  return difference;
}

}  // namespace orient
