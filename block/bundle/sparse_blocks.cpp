#include "block/bundle/sparse_blocks.h"

#include <Eigen/Dense>
#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace orient::block {
namespace {

// For a unit diagonal: a smaller pivot is rounding error of an unknown dependent on the others.
constexpr double kOpen = 1e-11;
// More columns at once than this gain nothing, and within a supernode work goes block by block.
constexpr int kMostColumns = 32;

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
  FindSupernodes();
  for (const Supernode& supernode : supernodes_) Factor(supernode);
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

// A column joins the one before it if it is that column's parent and has the same rows otherwise.
void BlockCholesky::FindSupernodes() {
  for (int j = 0; j < static_cast<int>(columns_.size()); ++j) {
    const bool joins = j > 0 && j - supernodes_.back().begin < kMostColumns &&
                       !columns_[Index(j - 1)].rows.empty() &&
                       columns_[Index(j - 1)].rows.front() == j &&
                       columns_[Index(j - 1)].rows.size() == columns_[Index(j)].rows.size() + 1;
    if (joins)
      ++supernodes_.back().end;
    else
      supernodes_.push_back({j, j + 1});
  }
}

const std::vector<int>& BlockCholesky::RowsBelow(const Supernode& supernode) const {
  return columns_[Index(supernode.end - 1)].rows;
}

template <class See>
void BlockCholesky::ForEachPair(const std::vector<int>& rows, const See& see) const {
  for (std::size_t a = 0; a < rows.size(); ++a) {
    const std::vector<int>& there = columns_[Index(rows[a])].rows;
    std::size_t place = 0;
    for (std::size_t b = a + 1; b < rows.size(); ++b) {
      while (there[place] != rows[b]) ++place;
      see(a, b, place);
    }
  }
}

Eigen::MatrixXd BlockCholesky::Triangle(const Supernode& supernode) const {
  Eigen::MatrixXd triangle = Eigen::MatrixXd::Zero(At(supernode.Size()), At(supernode.Size()));
  for (int k = 0; k < supernode.Size(); ++k) {
    triangle.block<6, 6>(At(k), At(k)) = diagonal_[Index(supernode.begin + k)];
    const Column& column = columns_[Index(supernode.begin + k)];
    for (int i = k + 1; i < supernode.Size(); ++i)
      triangle.block<6, 6>(At(i), At(k)) = column.values[Index(i - k - 1)];
  }
  return triangle;
}

Eigen::MatrixXd BlockCholesky::Below(const Supernode& supernode) const {
  const int rows = static_cast<int>(RowsBelow(supernode).size());
  Eigen::MatrixXd below(At(rows), At(supernode.Size()));
  for (int k = 0; k < supernode.Size(); ++k) {
    const Column& column = columns_[Index(supernode.begin + k)];
    for (int i = 0; i < rows; ++i)
      below.block<6, 6>(At(i), At(k)) = column.values[Index(supernode.Size() - 1 - k + i)];
  }
  return below;
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

// Solves for the column's blocks and subtracts their products from the later ones before `end`.
void BlockCholesky::FactorColumn(int column, int end) {
  const Matrix6d lower = diagonal_[Index(column)];
  Column& of = columns_[Index(column)];
  for (Matrix6d& value : of.values)
    lower.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(value);
  for (int j = column + 1; j < end; ++j) {
    const std::size_t place = Index(j - column - 1);
    const Matrix6d& left = of.values[place];
    diagonal_[Index(j)].noalias() -= left * left.transpose();
    std::vector<Matrix6d>& to = columns_[Index(j)].values;
    for (std::size_t i = 0; i < to.size(); ++i)
      to[i].noalias() -= of.values[place + 1 + i] * left.transpose();
  }
}

void BlockCholesky::Factor(const Supernode& supernode) {
  for (int column = supernode.begin; column < supernode.end; ++column) {
    FactorDiagonal(column);
    FactorColumn(column, supernode.end);
  }
  const std::vector<int>& rows = RowsBelow(supernode);
  if (rows.empty()) return;
  const Eigen::MatrixXd below = Below(supernode);
  Eigen::MatrixXd taken(below.rows(), below.rows());
  taken.triangularView<Eigen::Lower>() = below * below.transpose();
  const auto block = [&](std::size_t row, std::size_t col) {
    return taken.block<6, 6>(At(static_cast<int>(row)), At(static_cast<int>(col)));
  };
  for (std::size_t a = 0; a < rows.size(); ++a)
    diagonal_[Index(rows[a])].triangularView<Eigen::Lower>() -= block(a, a);
  ForEachPair(rows, [&](std::size_t a, std::size_t b, std::size_t place) {
    columns_[Index(rows[a])].values[place] -= block(b, a);
  });
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
  for (Column& column : columns_) column.inverse.resize(column.rows.size());
  for (std::size_t i = supernodes_.size(); i-- > 0;) Invert(supernodes_[i]);
}

// The lower triangle of the inverse's blocks for these rows.
Eigen::MatrixXd BlockCholesky::InverseOf(const std::vector<int>& rows) const {
  const int count = static_cast<int>(rows.size());
  Eigen::MatrixXd inverse(At(count), At(count));
  for (int a = 0; a < count; ++a)
    inverse.block<6, 6>(At(a), At(a)) = inverse_diagonal_[Index(rows[Index(a)])];
  ForEachPair(rows, [&](std::size_t a, std::size_t b, std::size_t place) {
    inverse.block<6, 6>(At(static_cast<int>(b)), At(static_cast<int>(a))) =
        columns_[Index(rows[a])].inverse[place];
  });
  return inverse;
}

// Takahashi's equations: with N = L(below) L(triangle)^-1, Z(below) = -Z(rows, rows) N and
// Z(triangle) = (L L')^-1 - N' Z(below).
void BlockCholesky::Invert(const Supernode& supernode) {
  const int size = supernode.Size();
  const Eigen::MatrixXd inverse_triangle = Triangle(supernode).triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd::Identity(At(size), At(size)));
  const std::vector<int>& rows = RowsBelow(supernode);
  const Eigen::MatrixXd below = Below(supernode) * inverse_triangle;
  Eigen::MatrixXd inverse_below(below.rows(), below.cols());
  if (!rows.empty())
    inverse_below.noalias() = -(InverseOf(rows).selfadjointView<Eigen::Lower>() * below);
  const Eigen::MatrixXd inverse =
      inverse_triangle.transpose() * inverse_triangle - below.transpose() * inverse_below;
  for (int k = 0; k < size; ++k) {
    inverse_diagonal_[Index(supernode.begin + k)] = inverse.block<6, 6>(At(k), At(k));
    std::vector<Matrix6d>& to = columns_[Index(supernode.begin + k)].inverse;
    std::size_t place = 0;
    for (int i = k + 1; i < size; ++i) to[place++] = inverse.block<6, 6>(At(i), At(k));
    for (int i = 0; i < static_cast<int>(rows.size()); ++i)
      to[place++] = inverse_below.block<6, 6>(At(i), At(k));
  }
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
