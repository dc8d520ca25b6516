// Decompositions of small dense matrices of any size. Eigen's would be recompiled, ten to twenty
// seconds each, in every file that names them: here they are compiled once.
#pragma once

#include <Eigen/Core>

namespace orient {

struct SymmetricEigen {
  Eigen::VectorXd values;   // ascending
  Eigen::MatrixXd vectors;  // columns of length 1, one per value
};

// Of a symmetric matrix (only the lower triangle is used).
SymmetricEigen EigenOfSymmetric(const Eigen::MatrixXd& symmetric);

// x of `normal` x = `right`, column by column; `normal` symmetric and positive semidefinite (LDLT).
Eigen::MatrixXd SolveNormal(const Eigen::MatrixXd& normal, const Eigen::MatrixXd& right);

// Of a square matrix that need not be definite (LU with full pivoting).
Eigen::MatrixXd InverseOf(const Eigen::MatrixXd& matrix);

// x that minimises |`matrix` x - `right`|, column by column; at least as many rows as columns, of
// full rank (Householder QR).
Eigen::MatrixXd LeastSquares(const Eigen::MatrixXd& matrix, const Eigen::MatrixXd& right);

// An orthonormal basis (columns) of the orthogonal complement of `matrix`'s columns (full rank).
Eigen::MatrixXd OrthogonalComplement(const Eigen::MatrixXd& matrix);

}  // namespace orient
