#include "core/geometry/dense_solvers.h"

#include <Eigen/Dense>

namespace orient {

using Eigen::MatrixXd;

SymmetricEigen EigenOfSymmetric(const MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(symmetric);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

MatrixXd SolveNormal(const MatrixXd& normal, const MatrixXd& right) {
  return normal.ldlt().solve(right);
}

MatrixXd InverseOf(const MatrixXd& matrix) { return matrix.fullPivLu().inverse(); }

MatrixXd LeastSquares(const MatrixXd& matrix, const MatrixXd& right) {
  return matrix.householderQr().solve(right);
}

MatrixXd OrthogonalComplement(const MatrixXd& matrix) {
  const MatrixXd q = matrix.householderQr().householderQ();
  return q.rightCols(matrix.rows() - matrix.cols());
}

}  // namespace orient
