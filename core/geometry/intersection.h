// Ground points from several oriented photos: the intersection of their rays.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/collinearity.h"
#include "core/geometry/pose.h"

namespace orient {

// The point with the least sum of squared distances to the rays (for two rays: the middle of their
// common perpendicular). A first value for IntersectPhotos. Empty for fewer than two rays, parallel
// rays, and a point behind one of the cameras.
std::optional<Eigen::Vector3d> IntersectRays(const std::vector<Ray>& rays);

struct PhotoObservation {
  const Camera* camera;  // not owned, never null
  Pose pose;
  Eigen::Vector2d photo_mm;  // measured
  Eigen::Matrix2d covariance_mm2 = Eigen::Matrix2d::Identity() * 1e-4;
};

struct IntersectionResult {
  Eigen::Vector3d ground_m;
  Eigen::Matrix3d covariance_m2;  // inverse normal matrix, a-priori sigma0 = 1, poses error-free
  std::vector<Eigen::Vector2d> residuals_mm;  // measured - computed
  double sigma0 = 0;                          // sqrt(v'Pv / degrees_of_freedom)
  int degrees_of_freedom = 0;
};

// Least squares by the collinearity equations over two or more photos. Empty when the rays have no
// common point in front of the cameras or are too nearly parallel.
std::optional<IntersectionResult> IntersectPhotos(const std::vector<PhotoObservation>& photos);

}  // namespace orient
