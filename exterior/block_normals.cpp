#include "exterior/block_normals.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/dense_solvers.h"

namespace orient {
namespace {

// A share of the residual smaller than this is what rounding and linearisation make of nothing.
constexpr double kLeastRedundancy = 0.02;
// Of the scaled 3 x 3 normal matrix of a point.
constexpr double kWeakPoint = 1e-10;

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

// v' Qvv^+ v for Qvv = I - N (used) or I + N (not used), whitened.
RowTest TestOf(const Eigen::VectorXd& v, const Eigen::MatrixXd& N, double loss_weight, bool used) {
  const Eigen::Index n = v.size();
  // With a robust weight w the observation counts by w only: cov(v) = I + (1 - 2 w) N.
  const double share = used ? 1 - 2 * loss_weight : 1;
  const SymmetricEigen eigen = EigenOfSymmetric(Eigen::MatrixXd::Identity(n, n) + share * N);
  RowTest test;
  test.square = v.squaredNorm();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (eigen.values[i] < kLeastRedundancy) continue;
    const double along = eigen.vectors.col(i).dot(v);
    test.t += along * along / eigen.values[i];
    ++test.dof;
  }
  test.redundancy = used ? static_cast<double>(n) - loss_weight * N.trace() : 0;
  return test;
}

}  // namespace

double ChiSquareLimit(int dof, double probability) {
  const auto tail = [dof](double x) {
    if (dof == 2) return std::exp(-x / 2);
    const double one = std::erfc(std::sqrt(x / 2));
    if (dof == 1) return one;
    constexpr double kPi = 3.14159265358979323846;
    return one + std::sqrt(2 * x / kPi) * std::exp(-x / 2);
  };
  double low = 0, high = 200;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (tail(middle) > probability ? low : high) = middle;
  }
  return low;
}

struct BlockNormals::PointEquations {
  Eigen::Matrix3d inverse;                          // of V = sum B'B
  std::vector<int> groups;                          // unknowns that its rows share with it
  Eigen::Matrix<double, 3, Eigen::Dynamic> weight;  // W = sum B'A
  std::vector<std::size_t> rows;                    // active first, then those only tested
  std::vector<LinearRows> linear;
  std::vector<double> loss_weight;
  std::size_t active = 0;

  Eigen::Index PlaceOf(int group) const {
    return 6 * (std::find(groups.begin(), groups.end(), group) - groups.begin());
  }
};

BlockNormals::BlockNormals(const BlockSystem& system, double cauchy_scale)
    : system_(system), cauchy_scale_(cauchy_scale) {
  SparseBlocks reduced(static_cast<int>(system.groups.size()));
  for (std::size_t point = 0; point < system.points.size(); ++point) AddPoint(point, &reduced);
  for (std::size_t i = system.block.observations.size(); i < system.rows.size(); ++i) {
    const BlockRows& row = system.rows[i];
    if (!row.active || row.point >= 0) continue;
    const LinearRows linear = system.Linearise(row);
    for (int a = 0; a < row.group_count; ++a)
      for (int b = 0; b <= a; ++b)
        reduced.Add(row.groups.at(Index(a)), row.groups.at(Index(b)),
                    linear.by_group.at(Index(a)).transpose() * linear.by_group.at(Index(b)));
  }
  // What no row mentions (a photo that takes no part) stays where it is.
  for (int group = 0; group < reduced.Count(); ++group)
    if (reduced.diagonal()[Index(group)].isZero(0)) reduced.Add(group, group, Matrix6d::Identity());
  cholesky_ = std::make_unique<BlockCholesky>(reduced);
}

double BlockNormals::LossWeight(const BlockRows& row, const LinearRows& linear) const {
  if (cauchy_scale_ <= 0 || row.point < 0) return 1;
  return 1 / (1 + linear.residual.squaredNorm() / (cauchy_scale_ * cauchy_scale_));
}

std::optional<BlockNormals::PointEquations> BlockNormals::EquationsOf(std::size_t point) const {
  PointEquations e;
  std::vector<std::size_t> tested;
  for (const std::size_t row : system_.image_rows_of_point[point])
    (system_.rows[row].active ? e.rows : tested).push_back(row);
  if (e.rows.empty()) return std::nullopt;
  if (const int control = system_.control_row_of_point[point]; control >= 0)
    for (const std::size_t row : {Index(control), Index(control) + 1})
      (system_.rows[row].active ? e.rows : tested).push_back(row);
  e.active = e.rows.size();
  e.rows.insert(e.rows.end(), tested.begin(), tested.end());
  for (const std::size_t i : e.rows) {
    const BlockRows& row = system_.rows[i];
    for (int g = 0; g < row.group_count; ++g)
      if (std::find(e.groups.begin(), e.groups.end(), row.groups.at(Index(g))) == e.groups.end())
        e.groups.push_back(row.groups.at(Index(g)));
  }
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  e.weight.setZero(3, 6 * static_cast<Eigen::Index>(e.groups.size()));
  for (std::size_t k = 0; k < e.rows.size(); ++k) {
    const BlockRows& row = system_.rows[e.rows[k]];
    e.linear.push_back(system_.Linearise(row));
    const LinearRows& linear = e.linear.back();
    const double w = k < e.active ? LossWeight(row, linear) : 0;
    e.loss_weight.push_back(w);
    if (k >= e.active) continue;
    V += w * linear.by_point.transpose() * linear.by_point;
    for (int g = 0; g < row.group_count; ++g)
      e.weight.middleCols<6>(e.PlaceOf(row.groups.at(Index(g)))) +=
          w * linear.by_point.transpose() * linear.by_group.at(Index(g));
  }
  const Eigen::Vector3d scale = V.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::Matrix3d scaled = scale.asDiagonal() * V * scale.asDiagonal();
  if (!(scaled.determinant() > kWeakPoint)) return std::nullopt;
  e.inverse = scale.asDiagonal() * scaled.inverse() * scale.asDiagonal();
  return e;
}

void BlockNormals::AddPoint(std::size_t point, SparseBlocks* reduced) {
  const auto e = EquationsOf(point);
  if (!e) {
    if (system_.Rays(point) > 0) weak_points_.push_back(point);
    return;
  }
  Eigen::MatrixXd sum = -e->weight.transpose() * e->inverse * e->weight;
  for (std::size_t k = 0; k < e->active; ++k) {
    const BlockRows& row = system_.rows[e->rows[k]];
    const LinearRows& linear = e->linear[k];
    for (std::size_t a = 0; a < Index(row.group_count); ++a)
      for (std::size_t b = 0; b < Index(row.group_count); ++b)
        sum.block<6, 6>(e->PlaceOf(row.groups.at(a)), e->PlaceOf(row.groups.at(b))) +=
            e->loss_weight[k] * linear.by_group.at(a).transpose() * linear.by_group.at(b);
  }
  const auto count = static_cast<Eigen::Index>(e->groups.size());
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = 0; b <= a; ++b)
      reduced->Add(e->groups[static_cast<std::size_t>(a)], e->groups[static_cast<std::size_t>(b)],
                   sum.block<6, 6>(6 * a, 6 * b));
}

BlockTests BlockNormals::Test() {
  cholesky_->Invert();
  BlockTests tests;
  tests.of_row.resize(system_.rows.size());
  tests.of_control.resize(system_.points.size());
  tests.point_covariance.assign(system_.points.size(), Eigen::Matrix3d::Zero());
  tbb::task_arena(system_.options.threads).execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, system_.points.size(), 256),
                      [&](const tbb::blocked_range<std::size_t>& range) {
                        for (std::size_t i = range.begin(); i < range.end(); ++i)
                          TestPoint(i, &tests);
                      });
  });
  for (std::size_t i = system_.block.observations.size(); i < system_.rows.size(); ++i)
    if (system_.rows[i].point < 0 && system_.rows[i].active) TestOther(i, &tests);
  return tests;
}

void BlockNormals::TestPoint(std::size_t point, BlockTests* tests) const {
  const auto e = EquationsOf(point);
  if (!e) return;
  const auto size = static_cast<Eigen::Index>(e->groups.size());
  Eigen::MatrixXd Q(6 * size, 6 * size);
  for (Eigen::Index a = 0; a < size; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const Matrix6d block = cholesky_->Inverse(e->groups[static_cast<std::size_t>(a)],
                                                e->groups[static_cast<std::size_t>(b)]);
      Q.block<6, 6>(6 * a, 6 * b) = block;
      Q.block<6, 6>(6 * b, 6 * a) = block.transpose();
    }
  const Eigen::MatrixXd by_groups = -e->inverse * e->weight;  // d point / d groups
  const Eigen::MatrixXd cross = Q * by_groups.transpose();
  const Eigen::Matrix3d own = e->inverse + by_groups * cross;
  tests->point_covariance[point] = own;
  Eigen::MatrixXd control_design = Eigen::MatrixXd::Zero(4, 6 * size + 3);
  Eigen::VectorXd control_residual = Eigen::VectorXd::Zero(4);
  bool control_used = false;
  double control_weight = 1;
  int control_rows = 0;
  const auto covariance_of = [&](const Eigen::MatrixXd& A, const Eigen::MatrixXd& B) {
    const Eigen::MatrixXd mixed = A * cross * B.transpose();
    return Eigen::MatrixXd(A * Q * A.transpose() + mixed + mixed.transpose() +
                           B * own * B.transpose());
  };
  for (std::size_t k = 0; k < e->rows.size(); ++k) {
    const BlockRows& row = system_.rows[e->rows[k]];
    const LinearRows& linear = e->linear[k];
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(linear.count, 6 * size);
    for (int g = 0; g < row.group_count; ++g)
      A.middleCols<6>(e->PlaceOf(row.groups.at(Index(g)))) +=
          linear.by_group.at(Index(g)).topRows(linear.count);
    const Eigen::MatrixXd B = linear.by_point.topRows(linear.count);
    if (row.kind == RowKind::kControlGround) {
      control_design.block(2 * control_rows, 0, 2, 6 * size) = A;
      control_design.block(2 * control_rows, 6 * size, 2, 3) = B;
      control_residual.segment(2 * control_rows, 2) = linear.residual.head<2>();
      control_used = k < e->active;
      control_weight = std::min(control_weight, control_used ? e->loss_weight[k] : 1.0);
      ++control_rows;
      continue;
    }
    tests->of_row[e->rows[k]] = TestOf(linear.residual.head(linear.count), covariance_of(A, B),
                                       e->loss_weight[k], k < e->active);
  }
  if (control_rows == 2)  // its fourth row is empty
    tests->of_control[point] = TestOf(control_residual.head(3),
                                      covariance_of(control_design.block(0, 0, 3, 6 * size),
                                                    control_design.block(0, 6 * size, 3, 3)),
                                      control_weight, control_used);
}

void BlockNormals::TestOther(std::size_t row_index, BlockTests* tests) const {
  const BlockRows& row = system_.rows[row_index];
  const LinearRows linear = system_.Linearise(row);
  Matrix6d N = Matrix6d::Zero();
  for (std::size_t a = 0; a < Index(row.group_count); ++a)
    for (std::size_t b = 0; b < Index(row.group_count); ++b)
      N += linear.by_group.at(a) * cholesky_->Inverse(row.groups.at(a), row.groups.at(b)) *
           linear.by_group.at(b).transpose();
  tests->of_row[row_index] = TestOf(linear.residual.head(linear.count),
                                    N.topLeftCorner(linear.count, linear.count), 1, true);
}

}  // namespace orient
