// The pose from observations that share errors.
//
// Some errors are common to many patches, and no residual of one patch shows them: heights that are
// wrong over a whole region move every patch cut with them along its source's line of sight, an
// error of the interior orientation moves the whole photo, and film bends between its marks. A
// covariance without them is too optimistic, and an adjustment without them spreads
// them over the frame where the patches end. Here they are part of the observations' covariance
// (generalised least squares; the height errors as a random field, as in least-squares collocation,
// Moritz 1980).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/resection.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/observation.h"
#include "exterior/steps/residual_trends.h"

namespace orient::exterior {

using Matrix7d = Eigen::Matrix<double, 7, 7>;

// Of a camera whose calibration is lost or doubtful.
struct PrincipalDistancePrior {
  double value_mm = 0, sigma_mm = 0;
};

struct CorrelatedPose {
  Pose pose;
  Matrix6d covariance;         // of the adjustment: what it knows and the residuals show
  Matrix6d honest_covariance;  // with what they do not show (unseen_errors.h)
  // The part of it common to the control's heights: more patches do not reduce it.
  Matrix6d common_height_covariance;
  // Variance components: what the residuals make of the observations' and of the heights'
  // variances.
  double noise_factor = 1;
  double height_factor = 1;
  std::vector<ResidualTrend> trends;  // of the residuals; in the honest covariance
  // Estimated with the pose where it is an unknown: what it leaves open is in the pose's
  // covariances. Sigma with what residuals do not show.
  double principal_distance_mm = 0, principal_distance_sigma_mm = 0;
  // Honest covariance of the pose and the principal distance (mm).
  Matrix7d with_distance = Matrix7d::Zero();
};

// Gauss-Newton from view.pose, variance components by restricted maximum likelihood (Patterson &
// Thompson 1971), the heights' between a hundredth and ten times their stated variance, the
// observations' at least a tenth; covariances are those of Student's distribution. Of more than 250
// observations neighbours are averaged: they share their errors. With
// `unknown` the principal distance is a seventh unknown, from the view's camera's. Over level
// ground the flying height absorbs it, and its sigma stays the prior's; film scale has the same
// effect and cannot be separated from it. Empty: fewer than four observations, or singular.
std::optional<CorrelatedPose> EstimateCorrelatedPose(
    const PhotoView& view, const PosePrior& prior,
    const std::vector<PatchObservation>& observations, const CommonErrors& common,
    const std::optional<PrincipalDistancePrior>& unknown = std::nullopt);

}  // namespace orient::exterior
