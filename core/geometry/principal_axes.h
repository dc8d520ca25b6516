// Eigenvalues of symmetric 2 x 2 matrices, and how nearly points lie on one line.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace orient {

struct PrincipalAxes {
  Eigen::Vector2d values = Eigen::Vector2d::Zero();       // ascending
  Eigen::Matrix2d vectors = Eigen::Matrix2d::Identity();  // columns of length 1, one per value
};

// In closed form. The iterative solver of any size, which this stands for, is no better on two
// rows and takes the compiler ten seconds wherever it is used.
PrincipalAxes AxesOf(const Eigen::Matrix2d& symmetric);

// Of the points' scatter about their mean, in the squared unit of the points: 0 across where they
// lie on one line, both 0 for fewer than two.
PrincipalAxes AxesOf(const std::vector<Eigen::Vector2d>& points);

// Spread across the best line over the spread along it, 0 (one line, or one place) to 1.
double Thickness(const std::vector<Eigen::Vector2d>& points);

}  // namespace orient
