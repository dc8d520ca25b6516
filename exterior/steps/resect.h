// Step 4, resect, second half: the pose from precise matches, with gross errors found by data
// snooping and a covariance consistent with the residuals.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/geometry/resection.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/correlated_pose.h"

namespace orient::exterior {

struct PoseEstimate {
  Pose pose;
  Matrix6d covariance;  // scaled with the observations' variance component
  // Including errors that residuals do not show (unseen_errors.h): the pose's precision. The search
  // continues with `covariance`, which describes what the next round may find.
  Matrix6d honest_covariance;
  Matrix6d common_height_covariance;  // of it, what the control's heights have in common
  double added_px2 = 0;               // to every observation's variance: what matching cannot see
  double sigma0_px = 0;               // of one image coordinate of average weight
  double prior_chi2 = 0;  // Mahalanobis distance^2 of the pose from the prior, 6 degrees of freedom
  std::vector<Eigen::Vector2d> residuals_px;  // measured - computed, of every observation
  std::vector<bool> rejected;                 // by data snooping
  int used = 0;
  std::vector<ResidualTrend> trends;
  // Area around an observation's computed position within which it passes as no gross error, px^2.
  std::vector<double> passing_px2;
};

// Robust start (Cauchy), then Baarda's data snooping: while the largest squared normalised residual
// of two dimensions exceeds 11.8 (99.7 %), that observation is removed. Empty when fewer than four
// remain or the adjustment is singular.
std::optional<PoseEstimate> EstimatePose(const PhotoView& view, const PosePrior& prior,
                                         const std::vector<PatchObservation>& observations,
                                         const CommonErrors& common = {});

// Chi-square of the difference of two poses that were found independently (six degrees of freedom),
// and what it may be at most: exceeded in one of ten thousand.
double Apart(const PosePrior& one, const PosePrior& other);
extern const double kMostApart;

// The largest one-sigma uncertainty, in scan pixels and one coordinate, with which a pose of this
// covariance projects points on the ground at `height_m` into the frame. Infinite where no part of
// the frame shows that ground, or the covariance is none.
double WorstProjectionSigma(const PhotoView& view, const Matrix6d& covariance, double height_m);
// The same of a pose and a principal distance (CorrelatedPose::with_distance).
double WorstSigmaWithDistance(const PhotoView& view, const Matrix7d& covariance, double height_m);

}  // namespace orient::exterior
