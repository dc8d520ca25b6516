// The pose from observations that share errors.
//
// Some errors are common to many patches, and no residual of one patch shows them: heights that are
// wrong over a whole region move every patch cut with them along its source's line of sight, an
// error of the interior orientation moves the whole photo, and film bends between its marks. A
// covariance without them promises more than it can hold, and an adjustment without them spreads
// them over the frame where the patches end. Here they are part of the observations' covariance
// (generalised least squares; the height errors as a random field, as in least-squares collocation,
// Moritz 1980).
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/photo_view.h"
#include "core/geometry/resection.h"

namespace orient {

struct PatchObservation {
  Eigen::Vector3d ground_m;
  Eigen::Vector2d pixel;           // scan, measured
  Eigen::Matrix2d covariance_px2;  // of this observation alone
  // How the ground point moves for each metre by which the heights under its source are wrong, and
  // how wrong they may be (one sigma); zero where nothing is known.
  Eigen::Vector3d height_effect = Eigen::Vector3d::Zero();
  double height_sigma_m = 0;
  // What it was cut from: observations of one source share smooth errors.
  std::int64_t source = 0;
};

struct CommonErrors {
  // Covariance of photo_from_pixel (a11 a12 a21 a22 t1 t2; mm), zero for digital cameras.
  Matrix6d interior = Matrix6d::Zero();
  // Smooth deformation of the film between its marks: one sigma, and the distance in the photo over
  // which it fades, both in scan pixels; zero for digital cameras.
  double film_sigma_px = 0;
  double film_correlation_px = 1;
  // Distance at which height errors are hardly related any more.
  double height_correlation_m = 1000;
};

// Of a camera whose calibration is lost or doubtful.
struct PrincipalDistancePrior {
  double value_mm = 0, sigma_mm = 0;
};

struct CorrelatedPose {
  Pose pose;
  Matrix6d covariance;         // of the adjustment: what it knows and the residuals show
  Matrix6d honest_covariance;  // with what they do not show (unseen_errors.h)
  // Variance components: what the residuals make of the observations' and of the heights'
  // variances.
  double noise_factor = 1;
  double height_factor = 1;
  // Estimated with the pose where it is freed: what it leaves open is in the pose's covariances.
  // Sigma with what residuals do not show.
  double principal_distance_mm = 0, principal_distance_sigma_mm = 0;
};

// Gauss-Newton from view.pose, variance components by restricted maximum likelihood (Patterson &
// Thompson 1971), the heights' between a hundredth and ten times their stated variance, the
// observations' at least a tenth; covariances are those of Student's distribution. Of more than 250
// observations every k-th is used: they share their errors, more of them add nothing. With `freed`
// the principal distance is a seventh unknown, from the view's camera's. On level ground the flying
// height takes what it may be, and its sigma stays the prior's; film scale has the same effect and
// cannot be told from it. Empty: fewer than four observations, or singular.
std::optional<CorrelatedPose> EstimateCorrelatedPose(
    const PhotoView& view, const PosePrior& prior,
    const std::vector<PatchObservation>& observations, const CommonErrors& common,
    const std::optional<PrincipalDistancePrior>& freed = std::nullopt);

}  // namespace orient
