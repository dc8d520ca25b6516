#include "core/geometry/principal_axes.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace orient {

PrincipalAxes AxesOf(const Eigen::Matrix2d& symmetric) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
  solver.computeDirect(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

PrincipalAxes AxesOf(const std::vector<Eigen::Vector2d>& points) {
  if (points.size() < 2) return {};
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) mean += point;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points)
    scatter += (point - mean) * (point - mean).transpose();
  return AxesOf(scatter);
}

double Thickness(const std::vector<Eigen::Vector2d>& points) {
  const PrincipalAxes axes = AxesOf(points);
  if (!(axes.values[1] > 0)) return 0;
  return std::sqrt(std::max(axes.values[0], 0.0) / axes.values[1]);
}

}  // namespace orient
