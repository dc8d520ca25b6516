#include "block/held_to_control.h"

#include "block/verdict/final_results.h"

namespace orient::block {

JudgedBlock HeldToControl(JudgedBlock with, JudgedBlock without) {
  const bool converged = with.adjusted.result.converged;
  const bool converged_without = without.adjusted.result.converged;
  if (!converged && converged_without) {
    without.findings.push_back({.reason = Reason::kAdjustedWithoutPriors});
    return without;
  }
  if (converged && !converged_without)
    HoldAllToControl(&with.results);
  else
    HoldToControl(without.results, &with.results);
  return with;
}

}  // namespace orient::block
