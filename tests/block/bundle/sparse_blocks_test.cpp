#include "block/bundle/sparse_blocks.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace orient::block {
namespace {

// A chain of photos, each tied to the next two, and all to the first (as to a camera).
SparseBlocks Chain(int count, std::mt19937* random) {
  std::normal_distribution<double> normal;
  SparseBlocks matrix(count);
  const auto add_pair = [&](int a, int b) {
    Eigen::Matrix<double, 4, 12> rows;
    for (Eigen::Index i = 0; i < rows.size(); ++i) rows.data()[i] = normal(*random);
    const Eigen::Matrix<double, 12, 12> product = rows.transpose() * rows;
    matrix.Add(a, a, product.topLeftCorner<6, 6>());
    matrix.Add(b, b, product.bottomRightCorner<6, 6>());
    matrix.Add(a, b, product.topRightCorner<6, 6>());
  };
  for (int i = 0; i < count; ++i) {
    matrix.Add(i, i, 0.3 * Matrix6d::Identity());
    if (i + 1 < count) add_pair(i, i + 1);
    if (i + 2 < count) add_pair(i + 2, i);
    if (i > 0) add_pair(0, i);
  }
  return matrix;
}

int RowOf(std::uint64_t key) { return static_cast<int>(key >> 32U); }
int ColOf(std::uint64_t key) { return static_cast<int>(key & 0xffffffffU); }

Eigen::MatrixXd Dense(const SparseBlocks& matrix) {
  const Eigen::Index size = 6 * static_cast<Eigen::Index>(matrix.Count());
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(size, size);
  for (int i = 0; i < matrix.Count(); ++i)
    dense.block<6, 6>(6 * i, 6 * i) = matrix.diagonal()[static_cast<std::size_t>(i)];
  for (const auto& [key, place] : matrix.places()) {
    dense.block<6, 6>(6 * RowOf(key), 6 * ColOf(key)) = matrix.lower()[place];
    dense.block<6, 6>(6 * ColOf(key), 6 * RowOf(key)) = matrix.lower()[place].transpose();
  }
  return dense;
}

void ExpectInverse(const SparseBlocks& matrix) {
  const Eigen::MatrixXd inverse = Dense(matrix).inverse();
  BlockCholesky cholesky(matrix);
  EXPECT_TRUE(cholesky.Open().empty());
  cholesky.Invert();
  for (int i = 0; i < matrix.Count(); ++i)
    EXPECT_LT((cholesky.Inverse(i, i) - inverse.block<6, 6>(6 * i, 6 * i)).norm(), 1e-9);
  for (const auto& [key, place] : matrix.places()) {
    const int row = RowOf(key), col = ColOf(key);
    EXPECT_LT((cholesky.Inverse(row, col) - inverse.block<6, 6>(6 * row, 6 * col)).norm(), 1e-9);
    EXPECT_LT((cholesky.Inverse(col, row) - inverse.block<6, 6>(6 * col, 6 * row)).norm(), 1e-9);
  }
  const Eigen::VectorXd right = Eigen::VectorXd::LinSpaced(inverse.rows(), -1, 2);
  EXPECT_LT((cholesky.Solve(right) - inverse * right).norm(), 1e-9);
}

TEST(SparseBlocks, TheInverseAtItsPlacesIsTheInverse) {
  std::mt19937 random(1);
  ExpectInverse(Chain(14, &random));
}

// A strip whose last forty photos are all tied to one another: more columns than one supernode
// takes.
TEST(SparseBlocks, TheInverseOfADensePartIsTheInverse) {
  std::mt19937 random(2);
  SparseBlocks matrix = Chain(90, &random);
  for (int i = 50; i < 90; ++i)
    for (int j = 50; j < i; ++j)
      matrix.Add(i, j, 0.01 * Matrix6d::NullaryExpr([&] {
                         return std::uniform_real_distribution<double>(-1, 1)(random);
                       }));
  ExpectInverse(matrix);
}

TEST(SparseBlocks, BlocksOfTheInverseThatAreNotComputedAreRefused) {
  SparseBlocks matrix(3);
  for (int i = 0; i < 3; ++i) matrix.Add(i, i, 2 * Matrix6d::Identity());
  matrix.Add(1, 0, 0.5 * Matrix6d::Identity());
  BlockCholesky cholesky(matrix);
  cholesky.Invert();
  EXPECT_FALSE(cholesky.InverseIfThere(2, 0));
  EXPECT_THROW(cholesky.Inverse(2, 0), std::invalid_argument);
}

TEST(SparseBlocks, ADirectionThatNothingFixesIsFound) {
  // Of the first two blocks only the difference of their first elements is known.
  SparseBlocks matrix(3);
  Matrix6d first = 4 * Matrix6d::Identity();
  matrix.Add(2, 2, first);
  first(0, 0) = 9;
  matrix.Add(0, 0, first);
  matrix.Add(1, 1, first);
  Matrix6d between = Matrix6d::Zero();
  between(0, 0) = -9;
  matrix.Add(1, 0, between);
  const BlockCholesky cholesky(matrix);
  ASSERT_EQ(cholesky.Open().size(), 1u);
  EXPECT_LT(cholesky.Open()[0].first, 2);
  EXPECT_EQ(cholesky.Open()[0].second, 0);
  const Eigen::VectorXd direction = cholesky.OpenDirection(0);
  EXPECT_NEAR(direction[0], direction[6], 1e-12);
  EXPECT_NEAR(std::abs(direction[0]), 1, 1e-12);
  EXPECT_NEAR(direction.norm(), std::sqrt(2.0), 1e-12);
}

// All photos are tied to one another: two supernodes, of 32 columns and of 8. What two photos know
// of their first elements only as a difference is open, wherever in them these photos come.
TEST(SparseBlocks, ADirectionThatNothingFixesIsFoundAmongManyColumns) {
  std::mt19937 random(3);
  constexpr int kCount = 40;
  const auto noise = [&] { return std::uniform_real_distribution<double>(-0.05, 0.05)(random); };
  for (const int second : {1, 20, 31, 32, 39}) {
    SparseBlocks matrix(kCount);
    for (int i = 0; i < kCount; ++i) {
      const bool loose = i == 0 || i == second;
      Matrix6d own = 4 * Matrix6d::Identity();
      if (loose) own(0, 0) = 9;
      matrix.Add(i, i, own);
      for (int j = 0; j < i; ++j) {
        Matrix6d between = Matrix6d::NullaryExpr(noise);
        if (loose) between.row(0).setZero();
        if (j == 0 || j == second) between.col(0).setZero();
        if (i == second && j == 0) between(0, 0) = -9;
        matrix.Add(i, j, between);
      }
    }
    BlockCholesky cholesky(matrix);
    ASSERT_EQ(cholesky.Open().size(), 1u) << second;
    const auto [block, element] = cholesky.Open()[0];
    EXPECT_TRUE(block == 0 || block == second);
    EXPECT_EQ(element, 0);
    const Eigen::VectorXd direction = cholesky.OpenDirection(0);
    EXPECT_NEAR(direction[0], direction[6 * second], 1e-9);
    EXPECT_NEAR(direction.norm(), std::sqrt(2.0), 1e-9);
    cholesky.Invert();
    const int free = block == 0 ? second : 0;  // of the two the other is known, 1 / 9
    EXPECT_NEAR(cholesky.Inverse(free, free)(0, 0), 1.0 / 9, 1e-9);
    EXPECT_LT(cholesky.Inverse(block, block)(0, 0), 1e-9);
  }
}

}  // namespace
}  // namespace orient::block
