// The collinearity equations, their derivatives, and their inverse as a ray.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace orient {

// With d = R' (P - P0): x = xp - c d0/d2 + delta_x, y = yp - c d1/d2 + delta_y.
// Empty for a point behind the camera (d2 >= 0) and for one so far outside the frame that the lens
// model has folded over.
std::optional<Eigen::Vector2d> PhotoFromGround(const Camera& camera, const Pose& pose,
                                               const Eigen::Vector3d& ground_m);

struct ProjectionDerivatives {
  Eigen::Vector2d photo_mm;
  Eigen::Matrix<double, 2, 6> by_pose;    // mm per m, mm per rad
  Eigen::Matrix<double, 2, 3> by_ground;  // mm per m
  Eigen::Vector2d by_principal_distance;  // mm per mm
};

std::optional<ProjectionDerivatives> PhotoFromGroundWithDerivatives(
    const Camera& camera, const Pose& pose, const Eigen::Vector3d& ground_m);

// Both of many points: what depends on the pose alone is computed once. The camera must outlive it.
class PosedCamera {
 public:
  PosedCamera(const Camera& camera, const Pose& pose);
  std::optional<Eigen::Vector2d> PhotoFromGround(const Eigen::Vector3d& ground_m) const;
  std::optional<ProjectionDerivatives> PhotoFromGroundWithDerivatives(
      const Eigen::Vector3d& ground_m) const;

 private:
  const Camera& camera_;
  Eigen::Matrix3d photo_from_ground_;
  Eigen::Vector3d position_m_;
  Eigen::Vector3d phi_axis_;  // about which phi rotates, in photo axes
};

struct Ray {
  Eigen::Vector3d origin_m;
  Eigen::Vector3d direction;  // unit length, away from the camera
};

// Empty where the lens model has no inverse.
std::optional<Ray> GroundRayFromPhoto(const Camera& camera, const Pose& pose,
                                      const Eigen::Vector2d& photo_mm);

}  // namespace orient
