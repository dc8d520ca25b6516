// Symmetric positive definite matrices of 6 x 6 blocks, most of them zero: the reduced normal
// equations of a block of photos. Cholesky's factor in an order that keeps it sparse (AMD), and the
// inverse at the factor's places without computing the rest (Takahashi, Fagan & Chin 1973), many
// columns at a time (supernodes: Ng & Peyton 1993): the covariances of every photo and of every two
// photos that share a point.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/geometry/pose.h"

namespace orient::block {

// The lower triangle, block by block.
class SparseBlocks {
 public:
  explicit SparseBlocks(int count) : diagonal_(static_cast<std::size_t>(count), Matrix6d::Zero()) {}

  int Count() const { return static_cast<int>(diagonal_.size()); }
  // Adds to block (row, col) of the whole symmetric matrix; for row == col the value must be
  // symmetric, for row != col its transpose goes to (col, row) by itself: add either, not both.
  void Add(int row, int col, const Matrix6d& value);

  const std::vector<Matrix6d>& diagonal() const { return diagonal_; }
  // Keys are row * 2^32 + col with row > col.
  const std::unordered_map<std::uint64_t, std::size_t>& places() const { return places_; }
  const std::vector<Matrix6d>& lower() const { return lower_; }

 private:
  std::vector<Matrix6d> diagonal_;
  std::unordered_map<std::uint64_t, std::size_t> places_;
  std::vector<Matrix6d> lower_;
};

class BlockCholesky {
 public:
  // Factors. Unknowns that follow from the others (a pivot below 1e-11 of their diagonal) are held
  // fixed; Open() has them, and the matrix is singular where there are any.
  explicit BlockCholesky(const SparseBlocks& matrix);

  // Pairs of block and element.
  const std::vector<std::pair<int, int>>& Open() const { return open_; }
  // A change of the unknowns that the equations do not notice: that of Open()[i]. Scaled with the
  // square roots of the diagonal, so that the unknowns compare.
  Eigen::VectorXd OpenDirection(std::size_t i) const;

  Eigen::VectorXd Solve(const Eigen::VectorXd& right) const;

  // Computes the inverse at the factor's places; then Inverse() may be called.
  void Invert();
  // Block (row, col) of the inverse, for blocks that were added to the matrix (and some more).
  // Empty elsewhere.
  std::optional<Matrix6d> InverseIfThere(int row, int col) const;
  // Throws std::invalid_argument elsewhere.
  Matrix6d Inverse(int row, int col) const;

 private:
  struct Column {
    std::vector<int> rows;         // below the diagonal, ascending
    std::vector<Matrix6d> values;  // of the factor
    std::vector<Matrix6d> inverse;
  };
  // Consecutive columns [begin, end): each has a block in every later one of them, and all have the
  // same rows below the last. Worked on together, as dense matrices.
  struct Supernode {
    int begin = 0, end = 0;
    int Size() const { return end - begin; }
  };

  void Order(const SparseBlocks& matrix);
  void Fill(const SparseBlocks& matrix);
  void FindStructure();
  void FindSupernodes();
  const std::vector<int>& RowsBelow(const Supernode& supernode) const;
  Eigen::MatrixXd Triangle(const Supernode& supernode) const;  // of the factor
  Eigen::MatrixXd Below(const Supernode& supernode) const;     // of the factor
  // see(a, b, place) for every two rows below a supernode, a < b: block (rows[b], rows[a]) has that
  // place in column rows[a].
  template <class See>
  void ForEachPair(const std::vector<int>& rows, const See& see) const;
  void FactorDiagonal(int column);
  void FactorColumn(int column, int end);
  void Factor(const Supernode& supernode);
  Eigen::MatrixXd InverseOf(const std::vector<int>& rows) const;
  void Invert(const Supernode& supernode);
  void Forward(Eigen::VectorXd* x) const;
  void Backward(Eigen::VectorXd* x) const;

  std::vector<int> place_of_;  // block -> place in the order of elimination
  std::vector<int> block_at_;  // and back
  std::vector<Vector6d> scale_;
  std::vector<Matrix6d> diagonal_;  // of the factor
  std::vector<Matrix6d> inverse_diagonal_;
  std::vector<Column> columns_;
  std::vector<Supernode> supernodes_;
  std::vector<std::pair<int, int>> open_;
};

}  // namespace orient::block
