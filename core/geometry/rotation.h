// Rotations by omega, phi, kappa, and angles. Radians inside; degrees exist in files only.
//
// R = Rx(omega) * Ry(phi) * Rz(kappa): right-handed rotations about X, the once rotated Y and the
// twice rotated Z (PAT-B, BINGO, OPK). R takes photo axes to ground axes.
#pragma once

#include <Eigen/Core>

namespace orient {

double RadFromDeg(double angle_deg);
double DegFromRad(double angle_rad);

// The same angle in (-pi, pi].
double NormalizeAngle(double angle_rad);

// R of the comment above from (omega, phi, kappa) in radians.
Eigen::Matrix3d GroundFromPhotoRotation(const Eigen::Vector3d& opk_rad);

// (omega, phi, kappa) of a rotation; phi in [-pi/2, pi/2], all in (-pi, pi]. At |phi| = pi/2 omega
// and kappa are not separable: omega is returned as 0.
Eigen::Vector3d OpkFromRotation(const Eigen::Matrix3d& ground_from_photo);

}  // namespace orient
