#include "core/terrain/dem_tiles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>
#include <stdexcept>
#include <thread>

#include "core/terrain/dem_grid.h"
#include "tests/support/shared_data.h"

namespace orient {
namespace {

constexpr int kColumns = 1300, kRows = 1100;  // 3 x 3 tiles, none of the last ones whole

// Steep enough that rays hit it anywhere, with holes.
float HeightOf(int column, int row) {
  if ((column * 7 + row * 13) % 997 == 0) return std::numeric_limits<float>::quiet_NaN();
  return static_cast<float>(50 * std::sin(column * 0.02) + 40 * std::cos(row * 0.03) +
                            (column * 31 + row * 17) % 5);
}

std::vector<float> Heights(int column, int row, int columns, int rows) {
  std::vector<float> heights;
  for (int r = row; r < row + rows; ++r)
    for (int c = column; c < column + columns; ++c) heights.push_back(HeightOf(c, r));
  return heights;
}

class DemTilesTest : public testing::Test {
 protected:
  DemGrid whole_{Heights(0, 0, kColumns, kRows), kColumns, kRows};
  std::mt19937 random_{TestSeed()};
  std::uniform_real_distribution<double> u_{-5, kColumns + 5}, v_{-5, kRows + 5};
};

TEST_F(DemTilesTest, AnswerAsTheGridInMemory) {
  const DemGrid tiled(Heights, kColumns, kRows);
  EXPECT_EQ(tiled.Min(), whole_.Min());
  EXPECT_EQ(tiled.Max(), whole_.Max());
  EXPECT_NEAR(tiled.Mean(), whole_.Mean(), 1e-6);
  for (int i = 0; i < 20000; ++i) {
    const double u = u_(random_), v = v_(random_);
    EXPECT_EQ(tiled.HeightAt(u, v), whole_.HeightAt(u, v)) << u << ", " << v;
  }
  for (int i = 0; i < 300; ++i) {
    const GridRay ray{u_(random_),       v_(random_), 150, u_(random_) - 600,
                      v_(random_) - 500, -300,        0,   1};
    DemGrid::Side one = DemGrid::Side::kUnknown, other = one;
    EXPECT_EQ(tiled.Trace(ray, &one), whole_.Trace(ray, &other));
    EXPECT_EQ(one, other);
  }
}

TEST_F(DemTilesTest, NeighboursOverTheBorderOfTilesAreOneSurface) {
  const DemTiles tiles(Heights, kColumns, kRows);
  for (const int column : {510, 511, 512, 1023, 1024, kColumns - 2}) {
    const CellHeights cell = tiles.Cell(column, 511);
    EXPECT_EQ(cell[1], HeightOf(column + 1, 511));
    EXPECT_EQ(cell[2], HeightOf(column, 512));
    EXPECT_EQ(cell[3], HeightOf(column + 1, 512));
  }
}

TEST_F(DemTilesTest, AreReadOnceWhileTheyAreKept) {
  int reads = 0;
  const auto counted = [&reads](int column, int row, int columns, int rows) {
    ++reads;
    return Heights(column, row, columns, rows);
  };
  const DemTiles tiles(counted, kColumns, kRows);
  for (int round = 0; round < 3; ++round)
    for (int row = 0; row < kRows - 1; row += 90)
      for (int column = 0; column < kColumns - 1; column += 90) tiles.Cell(column, row);
  EXPECT_EQ(reads, 9);
}

// More tiles than are kept: 70 in a row.
TEST_F(DemTilesTest, ManyAreForgottenAndReadAgain) {
  std::size_t largest = 0;
  int reads = 0;
  const auto counted = [&](int column, int row, int columns, int rows) {
    ++reads;
    auto heights = Heights(column, row, columns, rows);
    largest = std::max(largest, heights.size());
    return heights;
  };
  constexpr int kMany = 70 * 512;
  const DemTiles tiles(counted, kMany, 3);
  for (int round = 0; round < 2; ++round)
    for (int column = 0; column < kMany - 1; column += 200)
      EXPECT_EQ(tiles.Cell(column, 1)[3], HeightOf(column + 1, 2)) << column;
  EXPECT_EQ(reads, 140);
  EXPECT_LE(largest, 513u * 3);
}

TEST_F(DemTilesTest, ThreadsGetTheSameHeights) {
  const DemGrid tiled(Heights, kColumns, kRows), other(Heights, kColumns, kRows);
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 4; ++seed)
    threads.emplace_back([&, seed] {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> u(0, kColumns - 1), v(0, kRows - 1);
      for (int i = 0; i < 5000; ++i) {
        const double a = u(random), b = v(random);
        const auto height = (i % 2 == 0 ? tiled : other).HeightAt(a, b);
        if (height != whole_.HeightAt(a, b)) ++wrong;
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST_F(DemTilesTest, FailureToReadComesOutOfTheQuestion) {
  bool broken = false;
  const auto read = [&broken](int column, int row, int columns, int rows) {
    if (broken) throw std::runtime_error("damaged");
    return Heights(column, row, columns, rows);
  };
  const DemTiles tiles(read, kColumns, kRows);
  tiles.Cell(0, 0);
  broken = true;
  EXPECT_THROW(tiles.Cell(600, 0), std::runtime_error);
  EXPECT_NO_THROW(tiles.Cell(0, 0));
  broken = false;
  EXPECT_EQ(tiles.Cell(600, 0)[0], HeightOf(600, 0));
}

}  // namespace
}  // namespace orient
