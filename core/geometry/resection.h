// Single-photo resection: the pose of a photo from image points with known ground position.
#pragma once

#include <Eigen/Core>
#include <array>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace orient {

struct ControlObservation {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d photo_mm;  // measured
  // Covariance of the measurement (mm^2), the ground point's own uncertainty included if wanted.
  Eigen::Matrix2d covariance_mm2 = Eigen::Matrix2d::Identity() * 1e-4;
};

struct PosePrior {
  Pose pose;
  Matrix6d covariance;  // x y z [m] omega phi kappa [rad]
};

// A prior's standard deviations of elements that are not stated.
inline constexpr double kOpenPosition_m = 1e5;
inline constexpr double kOpenAttitude_rad = std::numbers::pi;

// The elements of the pose that the prior constrains.
std::vector<Eigen::Index> StatedElements(const PosePrior& prior);

// All poses (up to four) from which three ground points are seen at three image points; closed
// form (Grunert's equations, after Haralick et al. 1994), then polished: every pose returned shows
// the three points within 1e-9 mm. Empty for collinear ground points and
// other degenerate triples (the danger cylinder gives double roots, not a crash).
std::vector<Pose> ResectThreePoints(const Camera& camera,
                                    const std::array<ControlObservation, 3>& observations);

struct ResectionOptions {
  std::optional<PosePrior> prior;
  // Scale of a Cauchy loss on the normalised residual length; 0: plain least squares.
  double robust_scale = 0;
  int max_iterations = 50;
  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

struct ResectionResult {
  Pose pose;
  // Inverse normal matrix with the given weights (a-priori sigma0 = 1): not scaled by sigma0. With
  // a robust loss each weight is lowered by the loss's slope, so that a gross error does not add
  // certainty; likewise in redundancy and sigma0.
  Matrix6d covariance;
  std::vector<Eigen::Vector2d> residuals_mm;  // measured - computed
  std::vector<double> redundancy;             // r of each observation (sum of its two, 0..2)
  double sigma0 = 0;  // sqrt(v'Pv / redundancy) over image observations and prior; 0 if none
  int degrees_of_freedom = 0;
  bool converged = false;
};

// Ceres adjustment of the six elements from a start pose. Empty when the problem is singular (too
// few points and no prior; at |phi| = 90 degrees, where omega and kappa are one), a point lies
// behind the camera of the start pose, or it does not converge.
std::optional<ResectionResult> Resect(const Camera& camera,
                                      const std::vector<ControlObservation>& observations,
                                      const Pose& start, const ResectionOptions& options = {});

}  // namespace orient
