#include "exterior/steps/unseen_errors.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>

#include "exterior/steps/error_model.h"

namespace orient::exterior {
namespace {

// Correlation, the same in col and row, of an error that decorrelates over the ground; `by_source`:
// each source has its own, so that there is none between sources.
Eigen::MatrixXd SmoothCorrelation(const std::vector<PatchObservation>& observations,
                                  double length_m, bool by_source) {
  const Eigen::Index n = std::ssize(observations);
  Eigen::MatrixXd correlation = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const PatchObservation& one = observations[static_cast<std::size_t>(i)];
      const PatchObservation& other = observations[static_cast<std::size_t>(j)];
      if (by_source && one.source != other.source) continue;
      const double distance = (one.ground_m - other.ground_m).head<2>().norm() / length_m;
      correlation(i, j) = std::exp(-distance * distance);
    }
  return correlation;
}

// Covariance of the unknowns due to an error of one pixel in each coordinate, so correlated.
Eigen::MatrixXd Propagated(const Eigen::MatrixXd& by_observation,
                           const Eigen::MatrixXd& correlation) {
  const auto by_col = by_observation(Eigen::all, Eigen::seq(0, Eigen::last, 2)).eval();
  const auto by_row = by_observation(Eigen::all, Eigen::seq(1, Eigen::last, 2)).eval();
  return by_col * correlation * by_col.transpose() + by_row * correlation * by_row.transpose();
}

}  // namespace

Eigen::MatrixXd CovarianceOfUnseenErrors(const LinearEstimator& estimator,
                                         const std::vector<PatchObservation>& observations,
                                         double correlation_m) {
  const auto& gain = estimator.by_observation;
  const auto by_col = gain(Eigen::all, Eigen::seq(0, Eigen::last, 2)).eval();
  const auto by_row = gain(Eigen::all, Eigen::seq(1, Eigen::last, 2)).eval();

  const Eigen::VectorXd shift_col = by_col.rowwise().sum(), shift_row = by_row.rowwise().sum();
  const Eigen::MatrixXd everywhere =
      shift_col * shift_col.transpose() + shift_row * shift_row.transpose();
  const Eigen::MatrixXd smooth =
      Propagated(gain, SmoothCorrelation(observations, correlation_m, true));
  Eigen::MatrixXd covariance =
      estimator.own_px2 * (kSharedEverywhere * kSharedEverywhere * everywhere +
                           kSharedSmoothly * kSharedSmoothly * smooth);
  // Small residuals do not mean that the error common to all heights is small.
  for (std::size_t kind = 0; kind < kHeightKinds; ++kind) {
    const Eigen::VectorXd common = gain * estimator.by_height_px[kind];
    const double missing = std::max(1 - estimator.height_factors[kind], 0.0);
    covariance += kCommonHeightShare * missing * common * common.transpose();
  }
  return covariance;
}

Eigen::MatrixXd CovarianceOfCommonHeights(const LinearEstimator& estimator) {
  const Eigen::Index unknowns = estimator.by_observation.rows();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (const Eigen::VectorXd& by_height : estimator.by_height_px) {
    const Eigen::VectorXd common = estimator.by_observation * by_height;
    covariance += kCommonHeightShare * common * common.transpose();
  }
  return covariance;
}

Eigen::MatrixXd CovarianceOfSources(const LinearEstimator& estimator,
                                    const std::vector<PatchObservation>& observations,
                                    double half_px) {
  std::map<std::int64_t, std::vector<Eigen::Index>> of_source;
  for (Eigen::Index i = 0; i < std::ssize(observations); ++i)
    of_source[observations[static_cast<std::size_t>(i)].source].push_back(i);
  const Eigen::Index unknowns = estimator.by_observation.rows();
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(unknowns, unknowns);
  for (const auto& [source, members] : of_source) {
    const auto at = [&](Eigen::Index i) -> const PatchObservation& {
      return observations[static_cast<std::size_t>(i)];
    };
    Eigen::Vector2d middle = Eigen::Vector2d::Zero();
    for (const Eigen::Index i : members) middle += at(i).pixel / std::ssize(members);
    Eigen::MatrixXd by_source = Eigen::MatrixXd::Zero(unknowns, 6);
    for (const Eigen::Index i : members) {
      const Eigen::Vector3d place = ((at(i).pixel - middle) / half_px).homogeneous();
      for (Eigen::Index k = 0; k < 3; ++k)
        by_source.middleCols<2>(2 * k) +=
            at(i).source_sigma_px * place[k] * estimator.by_observation.middleCols<2>(2 * i);
    }
    covariance += by_source * by_source.transpose();
  }
  return covariance;
}

Eigen::MatrixXd CovarianceOfTrends(const LinearEstimator& estimator,
                                   const std::vector<PatchObservation>& observations,
                                   double variance_px2, double correlation_m) {
  return variance_px2 * Propagated(estimator.by_observation,
                                   SmoothCorrelation(observations, correlation_m, false));
}

}  // namespace orient::exterior
