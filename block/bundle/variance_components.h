// Variance components: factors of the groups' stated variances, from residuals. Each function does
// nothing if BlockOptions asks for the stated variances. Private to block.
#pragma once

#include "block/bundle/equations.h"
#include "block/bundle/normal_equations.h"

namespace orient::block {

// Image groups, from the medians of squared residuals of a robust adjustment.
void FactorsFromResiduals(BlockSystem* system);

// Image groups, GNSS and priors, from the medians of the tests, which are rescaled with the
// factors. True where a factor changed enough to adjust again.
bool FactorsFromMedians(BlockSystem* system, BlockTests* tests);

// All groups, v'Pv over the redundancy. True where a factor changed enough to adjust again.
bool FactorsFromSums(const BlockTests& tests, BlockSystem* system);

// While it lives, no group has less than BlockOptions::least_precision_factor of its stated
// variances: for covariances.
class StatedPrecision {
 public:
  explicit StatedPrecision(BlockSystem* system);
  ~StatedPrecision() { system_->weight = weight_; }
  StatedPrecision(const StatedPrecision&) = delete;
  StatedPrecision& operator=(const StatedPrecision&) = delete;

  // Whether any group's variances became larger.
  bool Matters() const { return system_->weight != weight_; }

 private:
  BlockSystem* system_;
  decltype(BlockSystem::weight) weight_;
};

}  // namespace orient::block
