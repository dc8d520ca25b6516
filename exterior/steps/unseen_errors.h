// What errors that the residuals hardly show, or do not show at all, add to a pose's covariance.
//
// Shadows and crowns lie on the same side of every object, so matches have a common error that the
// pose follows; heights may have a constant error however well the residuals fit; some patches show
// a building that is in no height model. The estimator need not weight such errors: the estimate is
// linear in the observations, so they are propagated through it as it is.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/pose.h"
#include "exterior/steps/linearised_matches.h"
#include "exterior/steps/observation.h"

namespace orient::exterior {

// Adjusted unknowns (a pose's, and others) as a function of the observations, two columns (col,
// row) for each of them.
struct LinearEstimator {
  Eigen::MatrixXd by_observation;  // d unknowns / d pixel
  double own_px2 = 0;              // of a single match, mean; its ground point's coordinates apart
  OfHeights<Eigen::VectorXd> by_height_px;  // per stated standard deviation of the height error
  // The heights' variances in the adjustment over the stated ones.
  OfHeights<double> height_factors = {1, 1};
};

// To be added to the unknowns' covariance of the adjustment; positive semidefinite.
Eigen::MatrixXd CovarianceOfUnseenErrors(const LinearEstimator& estimator,
                                         const std::vector<PatchObservation>& observations,
                                         double correlation_m);

// The same of what is common to all heights, as far as their stated accuracy goes: part of the
// above and of the adjustment's. No patch that was cut with them reveals it.
Eigen::MatrixXd CovarianceOfCommonHeights(const LinearEstimator& estimator);

// The same of sources that are displaced and deformed as a whole: their source_sigma_px, over their
// middle and over `half_px` from it.
Eigen::MatrixXd CovarianceOfSources(const LinearEstimator& estimator,
                                    const std::vector<PatchObservation>& observations,
                                    double half_px);

// The same of errors that the residuals do show, as trends (residual_trends.h) of this variance in
// one coordinate: errors with the same decorrelation over the ground that the pose has absorbed.
Eigen::MatrixXd CovarianceOfTrends(const LinearEstimator& estimator,
                                   const std::vector<PatchObservation>& observations,
                                   double variance_px2, double correlation_m);

}  // namespace orient::exterior
