// What the attempts to find a patch say about the next one. Pure functions.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "patchdb/store/patch.h"

namespace orient::patchdb {

// One patch searched for in one photo, as far as learning cares.
struct AttemptOutcome {
  std::string state;                        // PatchState's name
  std::optional<std::string> photo_status;  // ok, weak, failed
  std::optional<std::string> photo_date;    // ISO 8601
  int epoch = 1;                            // of the patch at that time
  // The nearest patches searched for in the same photo, and how many of them matched.
  std::optional<int> neighbours_sought, neighbours_matched;
};

struct SuccessWeights {
  double success = 0, failure = 0;
};

// Every attempt counts 1, but half in a weak photo and not at all in a failed one (its pose was
// wrong, not the patch); a quarter for each epoch since; half for each 20 years by which the photo
// is older than the newest one here. `not_visible` is no attempt.
SuccessWeights WeighAttempts(const std::vector<AttemptOutcome>& attempts, int epoch);

// Beta distribution of the probability that the next attempt succeeds. Before any attempt it has
// the mean of the patch's quality (0.5 where unknown) and the weight of two attempts.
struct SuccessBelief {
  double alpha = 1, beta = 1;
  double Mean() const { return alpha / (alpha + beta); }
  double Sigma() const;
};
SuccessBelief BeliefOf(const std::optional<double>& quality, const SuccessWeights& weights);
SuccessBelief BeliefOf(const Patch& patch);

// Why a patch should be retired: it failed in at least three photos that were oriented and where
// most of its neighbours matched, since its present epoch, and at least three times as often as it
// matched. Empty: it should not.
std::optional<std::string> WhyRetire(const std::vector<AttemptOutcome>& attempts, int epoch);

}  // namespace orient::patchdb
