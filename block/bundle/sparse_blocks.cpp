#include "block/bundle/sparse_blocks.h"

#include <Eigen/Dense>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace orient::block {
namespace {

// Of a unit diagonal: what remains of an unknown that follows from the others is rounding.
constexpr double kOpen = 1e-11;

std::uint64_t Key(int row, int col) {
  return (static_cast<std::uint64_t>(row) << 32U) | static_cast<std::uint64_t>(col);
}
int RowOf(std::uint64_t key) { return static_cast<int>(key >> 32U); }
int ColOf(std::uint64_t key) { return static_cast<int>(key & 0xffffffffU); }

Eigen::Index At(int block) { return 6 * static_cast<Eigen::Index>(block); }
std::size_t Index(int i) { return static_cast<std::size_t>(i); }

}  // namespace

void SparseBlocks::Add(int row, int col, const Matrix6d& value) {
  if (row == col) {
    diagonal_[Index(row)] += value;
    return;
  }
  const auto [place, is_new] =
      places_.try_emplace(Key(std::max(row, col), std::min(row, col)), lower_.size());
  if (is_new) lower_.emplace_back(Matrix6d::Zero());
  if (row > col)
    lower_[place->second] += value;
  else
    lower_[place->second] += value.transpose();
}

BlockCholesky::BlockCholesky(const SparseBlocks& matrix) {
  Order(matrix);
  Fill(matrix);
  FindStructure();
  for (int column = 0; column < matrix.Count(); ++column) {
    FactorDiagonal(column);
    FactorColumn(column);
  }
}

void BlockCholesky::Order(const SparseBlocks& matrix) {
  const int count = matrix.Count();
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < count; ++i) entries.emplace_back(i, i, 1);
  for (const auto& [key, place] : matrix.places()) {
    entries.emplace_back(RowOf(key), ColOf(key), 1);
    entries.emplace_back(ColOf(key), RowOf(key), 1);
  }
  Eigen::SparseMatrix<double> pattern(count, count);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order(count);
  Eigen::AMDOrdering<int>()(pattern, order);
  block_at_.assign(order.indices().data(), order.indices().data() + count);
  place_of_.resize(Index(count));
  for (int i = 0; i < count; ++i) place_of_[Index(block_at_[Index(i)])] = i;
}

void BlockCholesky::Fill(const SparseBlocks& matrix) {
  const int count = matrix.Count();
  diagonal_.resize(Index(count));
  scale_.resize(Index(count));
  columns_.resize(Index(count));
  for (int i = 0; i < count; ++i) {
    const Matrix6d& block = matrix.diagonal()[Index(block_at_[Index(i)])];
    Vector6d& scale = scale_[Index(i)];
    for (int k = 0; k < 6; ++k) scale[k] = block(k, k) > 0 ? 1 / std::sqrt(block(k, k)) : 1;
    diagonal_[Index(i)] = scale.asDiagonal() * block * scale.asDiagonal();
  }
  std::vector<std::uint64_t> keys;
  for (const auto& [key, place] : matrix.places()) keys.push_back(key);
  // Sorted by place, so that the columns' rows ascend and the result depends on no hash.
  const auto permuted = [&](std::uint64_t key) {
    const int a = place_of_[Index(RowOf(key))], b = place_of_[Index(ColOf(key))];
    return Key(std::min(a, b), std::max(a, b));
  };
  std::sort(keys.begin(), keys.end(),
            [&](std::uint64_t a, std::uint64_t b) { return permuted(a) < permuted(b); });
  for (const std::uint64_t key : keys) {
    const int row = place_of_[Index(RowOf(key))], col = place_of_[Index(ColOf(key))];
    const Matrix6d& block = matrix.lower()[matrix.places().at(key)];
    const Matrix6d scaled =
        scale_[Index(row)].asDiagonal() * block * scale_[Index(col)].asDiagonal();
    Column& column = columns_[Index(std::min(row, col))];
    column.rows.push_back(std::max(row, col));
    column.values.push_back(row > col ? scaled : Matrix6d(scaled.transpose()));
  }
}

// The factor has a block where the matrix has one or where an earlier column brings one: a column
// hands its rows to the first of them (its parent in the elimination tree).
void BlockCholesky::FindStructure() {
  for (Column& column : columns_) {
    if (column.rows.empty()) continue;
    Column& parent = columns_[Index(column.rows.front())];
    std::vector<int> rows;
    std::set_union(column.rows.begin() + 1, column.rows.end(), parent.rows.begin(),
                   parent.rows.end(), std::back_inserter(rows));
    std::vector<Matrix6d> values(rows.size(), Matrix6d::Zero());
    std::size_t place = 0;
    for (std::size_t i = 0; i < parent.rows.size(); ++i) {
      while (rows[place] != parent.rows[i]) ++place;
      values[place] = parent.values[i];
    }
    parent.rows = std::move(rows);
    parent.values = std::move(values);
  }
}

// Cholesky's decomposition of the diagonal block in place, row by row.
void BlockCholesky::FactorDiagonal(int column) {
  Matrix6d& block = diagonal_[Index(column)];
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < i; ++j)
      block(i, j) = (block(i, j) - block.row(i).head(j).dot(block.row(j).head(j))) / block(j, j);
    const double pivot = block(i, i) - block.row(i).head(i).squaredNorm();
    if (pivot > kOpen) {
      block(i, i) = std::sqrt(pivot);
      continue;
    }
    open_.emplace_back(block_at_[Index(column)], i);
    block(i, i) = 1e150;  // held fixed: whatever is divided by it vanishes
  }
  block.triangularView<Eigen::StrictlyUpper>().setZero();
}

void BlockCholesky::FactorColumn(int column) {
  const Matrix6d lower = diagonal_[Index(column)];
  Column& of = columns_[Index(column)];
  for (Matrix6d& value : of.values)
    lower.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(value);
  for (std::size_t a = 0; a < of.rows.size(); ++a) {
    const Matrix6d& left = of.values[a];
    diagonal_[Index(of.rows[a])].noalias() -= left * left.transpose();
    Column& to = columns_[Index(of.rows[a])];
    std::size_t place = 0;
    for (std::size_t b = a + 1; b < of.rows.size(); ++b) {
      while (to.rows[place] != of.rows[b]) ++place;
      to.values[place].noalias() -= of.values[b] * left.transpose();
    }
  }
}

// L y = x, then L' x = y; in the order of elimination and with the scaled unknowns.
void BlockCholesky::Forward(Eigen::VectorXd* x) const {
  for (int j = 0; j < static_cast<int>(columns_.size()); ++j) {
    const Vector6d solved =
        diagonal_[Index(j)].triangularView<Eigen::Lower>().solve(Vector6d(x->segment<6>(At(j))));
    x->segment<6>(At(j)) = solved;
    const Column& column = columns_[Index(j)];
    for (std::size_t i = 0; i < column.rows.size(); ++i)
      x->segment<6>(At(column.rows[i])) -= column.values[i] * solved;
  }
}

void BlockCholesky::Backward(Eigen::VectorXd* x) const {
  for (int j = static_cast<int>(columns_.size()) - 1; j >= 0; --j) {
    Vector6d sum = x->segment<6>(At(j));
    const Column& column = columns_[Index(j)];
    for (std::size_t i = 0; i < column.rows.size(); ++i)
      sum -= column.values[i].transpose() * x->segment<6>(At(column.rows[i]));
    x->segment<6>(At(j)) =
        diagonal_[Index(j)].triangularView<Eigen::Lower>().transpose().solve(sum);
  }
}

Eigen::VectorXd BlockCholesky::Solve(const Eigen::VectorXd& right) const {
  Eigen::VectorXd x(right.size()), result(right.size());
  for (int i = 0; i < static_cast<int>(block_at_.size()); ++i)
    x.segment<6>(At(i)) = scale_[Index(i)].cwiseProduct(right.segment<6>(At(block_at_[Index(i)])));
  Forward(&x);
  Backward(&x);
  for (int i = 0; i < static_cast<int>(block_at_.size()); ++i)
    result.segment<6>(At(block_at_[Index(i)])) = scale_[Index(i)].cwiseProduct(x.segment<6>(At(i)));
  return result;
}

Eigen::VectorXd BlockCholesky::OpenDirection(std::size_t i) const {
  const auto [block, element] = open_.at(i);
  const int place = place_of_[Index(block)];
  Eigen::VectorXd x = Eigen::VectorXd::Zero(At(static_cast<int>(columns_.size())));
  // Its pivot is so large that the unknown itself comes out as one.
  x[At(place) + element] = diagonal_[Index(place)](element, element);
  Backward(&x);
  Eigen::VectorXd direction(x.size());
  for (int j = 0; j < static_cast<int>(block_at_.size()); ++j)
    direction.segment<6>(At(block_at_[Index(j)])) = x.segment<6>(At(j));
  return direction;
}

void BlockCholesky::Invert() {
  inverse_diagonal_.resize(diagonal_.size());
  for (int j = static_cast<int>(columns_.size()) - 1; j >= 0; --j) InvertColumn(j);
}

// Takahashi's equations: with N = L(below) L(diagonal)^-1, Z(below) = -Z(rows, rows) N and
// Z(diagonal) = (L L')^-1 - N' Z(below).
void BlockCholesky::InvertColumn(int j) {
  Column& column = columns_[Index(j)];
  const Matrix6d inverse_lower =
      diagonal_[Index(j)].triangularView<Eigen::Lower>().solve(Matrix6d::Identity());
  const auto rows = static_cast<Eigen::Index>(column.rows.size());
  Eigen::MatrixXd all(6 * rows, 6 * rows), below(6 * rows, 6);
  for (Eigen::Index a = 0; a < rows; ++a) {
    below.middleRows<6>(6 * a) = column.values[static_cast<std::size_t>(a)] * inverse_lower;
    const int row_a = column.rows[static_cast<std::size_t>(a)];
    all.block<6, 6>(6 * a, 6 * a) = inverse_diagonal_[Index(row_a)];
    const Column& known = columns_[Index(row_a)];
    std::size_t place = 0;
    for (Eigen::Index b = a + 1; b < rows; ++b) {
      while (known.rows[place] != column.rows[static_cast<std::size_t>(b)]) ++place;
      all.block<6, 6>(6 * b, 6 * a) = known.inverse[place];
      all.block<6, 6>(6 * a, 6 * b) = known.inverse[place].transpose();
    }
  }
  const Eigen::MatrixXd inverse = -all * below;
  column.inverse.resize(column.rows.size());
  for (Eigen::Index a = 0; a < rows; ++a)
    column.inverse[static_cast<std::size_t>(a)] = inverse.middleRows<6>(6 * a);
  inverse_diagonal_[Index(j)] =
      inverse_lower.transpose() * inverse_lower - below.transpose() * inverse;
}

std::optional<Matrix6d> BlockCholesky::InverseIfThere(int row, int col) const {
  const int a = place_of_[Index(row)], b = place_of_[Index(col)];
  const auto unscaled = [&](const Matrix6d& scaled) {
    return Matrix6d(scale_[Index(a)].asDiagonal() * scaled * scale_[Index(b)].asDiagonal());
  };
  if (a == b) return unscaled(inverse_diagonal_[Index(a)]);
  const Column& column = columns_[Index(std::min(a, b))];
  const auto place = std::lower_bound(column.rows.begin(), column.rows.end(), std::max(a, b));
  if (place == column.rows.end() || *place != std::max(a, b)) return std::nullopt;
  const Matrix6d& below = column.inverse[static_cast<std::size_t>(place - column.rows.begin())];
  return unscaled(a > b ? below : Matrix6d(below.transpose()));
}

Matrix6d BlockCholesky::Inverse(int row, int col) const {
  const auto inverse = InverseIfThere(row, col);
  if (!inverse) throw std::invalid_argument("these two blocks of the inverse are not computed");
  return *inverse;
}

}  // namespace orient::block
