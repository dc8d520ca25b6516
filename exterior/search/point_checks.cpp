#include "exterior/search/point_checks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/chi_square.h"
#include "core/terrain/view_over_ground.h"

namespace orient::exterior {
namespace {

constexpr double kPower = 0.84;  // sigmas beyond the bound: detected in four of five cases
// Redundancy of a direction, 0..1, below which its residual is not tested.
constexpr double kTestable = 1e-4;
constexpr double kLeastRedundancy = 1e-12;

// Error of a whitened observation, of redundancy 1, that its test detects.
double Detected(std::size_t points) { return std::sqrt(PointChiSquareLimit(points)) + kPower; }

}  // namespace

Eigen::Matrix2d ObservedCovariance(const MeasuredPoint& point, const PixelDerivatives& d) {
  return point.sigma_px * point.sigma_px * Eigen::Matrix2d::Identity() +
         d.by_ground * point.sigma_m.cwiseAbs2().asDiagonal() * d.by_ground.transpose();
}

double PointChiSquareLimit(std::size_t points) {
  return ChiSquareLimit(2, kPointSignificance / static_cast<double>(points));
}

PointCheck CheckPoint(const PhotoView& view, const Matrix6d& covariance, const MeasuredPoint& point,
                      std::size_t points) {
  PointCheck check;
  const auto seen = view.PixelFromGround(point.ground_m);
  const auto d = PixelFromGroundWithDerivatives(view, point.ground_m);
  if (!seen || !d) {
    check.chi2 = std::numeric_limits<double>::infinity();
    return check;
  }
  // Whitened with the observation's covariance, so that a poor direction does not mask a good one.
  const Eigen::LLT<Eigen::Matrix2d> observed(ObservedCovariance(point, *d));
  const Eigen::Vector2d off = observed.matrixL().solve(point.pixel - *seen);
  const Eigen::Matrix<double, 2, 6> design = observed.matrixL().solve(d->by_pose);
  const Eigen::Matrix<double, 6, 2> moved = covariance * design.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> redundancy(Eigen::Matrix2d::Identity() -
                                                                  design * moved);
  const double shows = Detected(points);
  for (int k = 0; k < 2; ++k) {
    const double r = redundancy.eigenvalues()[k];
    const Eigen::Vector2d along = redundancy.eigenvectors().col(k);
    if (r > kTestable) check.chi2 += std::pow(along.dot(off), 2) / r;
    const Vector6d by = moved * along * (shows / std::sqrt(std::max(r, kLeastRedundancy)));
    check.hidden += by * by.transpose();
  }
  return check;
}

Matrix6d HiddenBy(const PhotoView& view, const Matrix6d& covariance, const MeasuredPoint& point,
                  std::size_t points, double redundancy) {
  const auto d = PixelFromGroundWithDerivatives(view, point.ground_m);
  if (!d) return Matrix6d::Zero();
  const Eigen::Matrix2d both = ObservedCovariance(point, *d);
  const Eigen::LLT<Eigen::Matrix2d> observed(both);
  const Eigen::Matrix<double, 6, 2> moved =
      covariance * observed.matrixL().solve(d->by_pose).transpose();
  const double shows = Detected(points);
  // An error shows in the residuals of the image and of the ground coordinates together.
  const double of_both =
      std::min(redundancy * both.trace() / (2 * point.sigma_px * point.sigma_px), 1.0);
  return moved * moved.transpose() * (shows * shows / std::max(of_both, kLeastRedundancy));
}

double HiddenDisplacement(const PointPose& pose, const PhotoView& view, double height_m) {
  double worst_px2 = 0;
  for (const SeenPlace& place : OutermostInFrame(view.camera, view.pose, height_m)) {
    const auto d = PixelFromGroundWithDerivatives(view, place.ground_m);
    if (!d) continue;
    for (const Matrix6d& hidden : pose.hidden) {
      const Eigen::Matrix2d moved = d->by_pose * hidden * d->by_pose.transpose();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> axes(moved, Eigen::EigenvaluesOnly);
      worst_px2 = std::max(worst_px2, axes.eigenvalues()[1]);
    }
  }
  return std::sqrt(worst_px2);
}

}  // namespace orient::exterior
