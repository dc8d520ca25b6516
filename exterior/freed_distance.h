// A pose together with the principal distance: for cameras whose calibration is lost or doubtful.
#pragma once

#include <optional>
#include <vector>

#include "core/geometry/photo_view.h"
#include "core/geometry/resection.h"
#include "exterior/correlated_pose.h"

namespace orient {

struct PrincipalDistancePrior {
  double value_mm = 0, sigma_mm = 0;
};

struct FreedPose {
  Pose pose;
  Matrix6d covariance;  // what the principal distance leaves open is in it
  double principal_distance_mm = 0, sigma_mm = 0;
};

// Generalised least squares over pose and principal distance from view.pose and the view's camera,
// both with their priors. The observations' covariances are scaled by `variance_factor`; their
// height errors are added as they are stated, half of them common to all, half fading over
// `height_correlation_m`. On level ground the flying height takes what the principal distance may
// be, and its sigma stays the prior's. Film scale has the same effect and cannot be told from it.
// Empty: fewer than four observations, or singular.
std::optional<FreedPose> EstimateFreedPose(const PhotoView& view, const PosePrior& prior,
                                           const PrincipalDistancePrior& distance,
                                           const std::vector<PatchObservation>& observations,
                                           double variance_factor, double height_correlation_m);

}  // namespace orient
