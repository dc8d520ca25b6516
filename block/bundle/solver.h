// Ceres on a block's equations: one problem for all rounds, rows taken out and put back as they
// are judged. Private to block.
#pragma once

#include <memory>

#include "block/bundle/equations.h"

namespace orient::block {

enum class BlockLoss { kNone, kHuber, kCauchy };

struct BlockSolve {
  BlockLoss loss = BlockLoss::kNone;
  double loss_scale = 2;    // of the normalised residual
  double tolerance = 1e-9;  // of the sum of squares, relative
  int max_iterations = 50;
};

class BlockSolver {
 public:
  explicit BlockSolver(BlockSystem* system);
  ~BlockSolver();
  BlockSolver(const BlockSolver&) = delete;
  BlockSolver& operator=(const BlockSolver&) = delete;

  // Moves the system's unknowns. False where Ceres found no descent or was stopped before it
  // converged. Adds to the timings.
  bool Solve(const BlockSolve& how, BlockTimings* timings);

 private:
  struct Problem;
  void Synchronise();

  BlockSystem* system_;
  std::unique_ptr<Problem> problem_;
};

}  // namespace orient::block
