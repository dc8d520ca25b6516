#include "block/bundle/normal_equations.h"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/geometry/dense_solvers.h"
#include "core/geometry/principal_axes.h"

namespace orient::block {
namespace {

// Smaller eigenvalues of Qvv are nothing but rounding and linearisation errors.
constexpr double kLeastRedundancy = 0.02;
// Smallest determinant of a point's scaled 3 x 3 normal matrix.
constexpr double kWeakPoint = 1e-10;

std::size_t Index(int i) { return static_cast<std::size_t>(i); }

// v' Qvv^+ v for Qvv = I - N (used) or I + N (not used), whitened. With a robust weight w the
// observation counts by w only: cov(v) = I + (1 - 2 w) N.
template <int n>
RowTest TestOf(const Eigen::Matrix<double, n, 1>& v, const Eigen::Matrix<double, n, n>& N,
               double loss_weight, bool used) {
  const double share = used ? 1 - 2 * loss_weight : 1;
  Eigen::Matrix<double, n, n> covariance = share * N;
  covariance.diagonal().array() += 1;
  Eigen::Matrix<double, n, 1> values;
  Eigen::Matrix<double, n, n> vectors;
  if constexpr (n == 2) {
    const PrincipalAxes axes = AxesOf(covariance);
    values = axes.values;
    vectors = axes.vectors;
  } else {
    const SymmetricEigen eigen = EigenOfSymmetric(covariance);
    values = eigen.values;
    vectors = eigen.vectors;
  }
  RowTest test;
  test.square = v.squaredNorm();
  for (Eigen::Index i = 0; i < v.size(); ++i) {
    if (values[i] < kLeastRedundancy) continue;
    const double along = vectors.col(i).dot(v);
    test.t += along * along / values[i];
    ++test.dof;
  }
  test.redundancy = used ? static_cast<double>(v.size()) - loss_weight * N.trace() : 0;
  return test;
}

}  // namespace

// A row's derivatives, and where its groups stand among those of its point.
struct PlacedRows {
  std::array<Eigen::Index, 3> places = {};
  int group_count = 0;
  const PointRows* linear = nullptr;
};

struct BlockNormals::PointEquations {
  Eigen::Matrix3d inverse;                          // of V = sum B'B
  std::vector<int> groups;                          // unknowns that its rows share with it
  Eigen::Matrix<double, 3, Eigen::Dynamic> weight;  // W = sum B'A
  std::vector<std::size_t> rows;                    // active first, then those only tested
  std::vector<PointRows> linear;
  std::vector<double> loss_weight;
  std::size_t active = 0;

  Eigen::Index PlaceOf(int group) const {
    return 6 * (std::find(groups.begin(), groups.end(), group) - groups.begin());
  }
  PlacedRows RowsAt(std::size_t k, const BlockRows& row) const {
    PlacedRows placed{{}, row.group_count, &linear[k]};
    for (std::size_t g = 0; g < Index(row.group_count); ++g)
      placed.places.at(g) = PlaceOf(row.groups.at(g));
    return placed;
  }
};

BlockNormals::BlockNormals(const BlockSystem& system, double cauchy_scale)
    : system_(system), cauchy_scale_(cauchy_scale) {
  SparseBlocks reduced(static_cast<int>(system.groups.size()));
  for (std::size_t point = 0; point < system.points.size(); ++point) AddPoint(point, &reduced);
  for (std::size_t i = system.block.observations.size(); i < system.rows.size(); ++i) {
    const BlockRows& row = system.rows[i];
    if (row.point >= 0) continue;
    const OtherRows linear = system.LineariseOther(row);
    // A rejected row needs its place in the inverse all the same, because it is tested.
    const double w = row.active ? LossWeight(row, linear) : 0;
    for (int a = 0; a < row.group_count; ++a)
      for (int b = 0; b <= a; ++b)
        reduced.Add(row.groups.at(Index(a)), row.groups.at(Index(b)),
                    w * linear.by_group.at(Index(a)).transpose() * linear.by_group.at(Index(b)));
  }
  // Unknowns that occur in no row (of a photo that takes no part) stay as they are.
  for (int group = 0; group < reduced.Count(); ++group)
    if (reduced.diagonal()[Index(group)].isZero(0)) reduced.Add(group, group, Matrix6d::Identity());
  cholesky_ = std::make_unique<BlockCholesky>(reduced);
}

double BlockNormals::LossWeight(double square) const {
  if (cauchy_scale_ <= 0) return 1;
  return 1 / (1 + square / (cauchy_scale_ * cauchy_scale_));
}

double BlockNormals::LossWeight(const BlockRows& row, const OtherRows& linear) const {
  return IsUnknown(row.kind) ? 1 : LossWeight(linear.residual.squaredNorm());
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
    e.linear.push_back(system_.LinearisePoint(row));
    const PointRows& linear = e.linear.back();
    const double w = k < e.active ? LossWeight(linear.residual.squaredNorm()) : 0;
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
    const PointRows& linear = e->linear[k];
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

bool BlockNormals::RightSideOfControl(std::size_t point, std::vector<int>* groups,
                                      Eigen::MatrixX3d* by_ground) const {
  const auto e = EquationsOf(point);
  if (!e) return false;
  Eigen::Matrix3d of_point = Eigen::Matrix3d::Zero();
  Eigen::MatrixX3d of_groups = Eigen::MatrixX3d::Zero(e->weight.cols(), 3);
  for (std::size_t k = 0; k < e->active; ++k) {
    const BlockRows& row = system_.rows[e->rows[k]];
    if (!IsGround(row.kind)) continue;
    const PointRows& linear = e->linear[k];
    of_point += e->loss_weight[k] * linear.by_point.transpose() * linear.by_point;
    for (std::size_t g = 0; g < Index(row.group_count); ++g)
      of_groups.middleRows<6>(e->PlaceOf(row.groups.at(g))) +=
          e->loss_weight[k] * linear.by_group.at(g).transpose() * linear.by_point;
  }
  *groups = e->groups;
  *by_ground = of_groups - e->weight.transpose() * e->inverse * of_point;
  return true;
}

bool BlockNormals::FollowsGroups(std::size_t point, std::vector<int>* groups,
                                 Eigen::Matrix3Xd* by_groups) const {
  const auto e = EquationsOf(point);
  if (!e) return false;
  *groups = e->groups;
  *by_groups = -e->inverse * e->weight;
  return true;
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
    if (system_.rows[i].point < 0) TestOther(i, &tests);
  return tests;
}

// Covariances of a point, of the groups that its rows share, and between the two.
struct BlockNormals::PointInverse {
  Eigen::MatrixXd groups;
  Eigen::Matrix<double, Eigen::Dynamic, 3> cross;
  Eigen::Matrix3d point;

  // Covariance of two rows' computed values, without the noise of their own observations.
  Eigen::Matrix2d Between(const PlacedRows& one, const PlacedRows& other) const {
    Eigen::Matrix2d sum = one.linear->by_point * point * other.linear->by_point.transpose();
    for (std::size_t a = 0; a < Index(one.group_count); ++a) {
      const Eigen::Matrix<double, 2, 6>& A = one.linear->by_group.at(a);
      sum += A * cross.middleRows<6>(one.places.at(a)) * other.linear->by_point.transpose();
      for (std::size_t b = 0; b < Index(other.group_count); ++b)
        sum += A * groups.block<6, 6>(one.places.at(a), other.places.at(b)) *
               other.linear->by_group.at(b).transpose();
    }
    for (std::size_t b = 0; b < Index(other.group_count); ++b)
      sum += one.linear->by_point * cross.middleRows<6>(other.places.at(b)).transpose() *
             other.linear->by_group.at(b).transpose();
    return sum;
  }
};

BlockNormals::PointInverse BlockNormals::InverseOf(const PointEquations& e) const {
  const auto size = static_cast<Eigen::Index>(e.groups.size());
  PointInverse inverse;
  inverse.groups.resize(6 * size, 6 * size);
  for (Eigen::Index a = 0; a < size; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const Matrix6d block = cholesky_->Inverse(e.groups[static_cast<std::size_t>(a)],
                                                e.groups[static_cast<std::size_t>(b)]);
      inverse.groups.block<6, 6>(6 * a, 6 * b) = block;
      if (a != b) inverse.groups.block<6, 6>(6 * b, 6 * a) = block.transpose();
    }
  const Eigen::Matrix<double, 3, Eigen::Dynamic> by_groups = -e.inverse * e.weight;
  inverse.cross.noalias() = inverse.groups * by_groups.transpose();
  inverse.point = e.inverse + by_groups * inverse.cross;
  return inverse;
}

void BlockNormals::TestPoint(std::size_t point, BlockTests* tests) const {
  const auto e = EquationsOf(point);
  if (!e) return;
  const PointInverse inverse = InverseOf(*e);
  tests->point_covariance[point] = inverse.point;
  for (std::size_t k = 0; k < e->rows.size(); ++k) {
    const BlockRows& row = system_.rows[e->rows[k]];
    if (IsGround(row.kind)) continue;
    const PlacedRows rows = e->RowsAt(k, row);
    tests->of_row[e->rows[k]] = TestOf<2>(e->linear[k].residual, inverse.Between(rows, rows),
                                          e->loss_weight[k], k < e->active);
  }
  if (system_.control_row_of_point[point] >= 0) tests->of_control[point] = TestControl(*e, inverse);
}

// Tests both pairs of control rows together; the fourth row is empty.
RowTest BlockNormals::TestControl(const PointEquations& e, const PointInverse& inverse) const {
  std::array<std::size_t, 2> at = {};
  std::size_t found = 0;
  for (std::size_t k = 0; k < e.rows.size(); ++k)
    if (IsGround(system_.rows[e.rows[k]].kind)) at.at(found++) = k;
  Eigen::Matrix4d N;
  Eigen::Vector4d v;
  for (int a = 0; a < 2; ++a)
    for (int b = 0; b < 2; ++b) {
      const std::size_t i = at.at(Index(a)), j = at.at(Index(b));
      N.block<2, 2>(2 * a, 2 * b) = inverse.Between(e.RowsAt(i, system_.rows[e.rows[i]]),
                                                    e.RowsAt(j, system_.rows[e.rows[j]]));
      v.segment<2>(2 * a) = e.linear[i].residual;
    }
  return TestOf<3>(v.head<3>(), N.topLeftCorner<3, 3>(),
                   std::min(e.loss_weight[at[0]], e.loss_weight[at[1]]), at[0] < e.active);
}

void BlockNormals::TestOther(std::size_t row_index, BlockTests* tests) const {
  const BlockRows& row = system_.rows[row_index];
  const OtherRows linear = system_.LineariseOther(row);
  Matrix6d N = Matrix6d::Zero();
  for (std::size_t a = 0; a < Index(row.group_count); ++a)
    for (std::size_t b = 0; b < Index(row.group_count); ++b)
      N += linear.by_group.at(a) * cholesky_->Inverse(row.groups.at(a), row.groups.at(b)) *
           linear.by_group.at(b).transpose();
  const double w = row.active ? LossWeight(row, linear) : 0;
  tests->of_row[row_index] =
      TestOf<Eigen::Dynamic>(linear.residual.head(linear.count),
                             N.topLeftCorner(linear.count, linear.count), w, row.active);
}

}  // namespace orient::block
