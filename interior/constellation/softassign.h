// Softassign with deterministic annealing (Jiang, Zhang & Li after Gold & Rangarajan and Chui &
// Rangarajan's TPS-RPM): which candidate is which mark, from positions alone.
//
// Every pair of a mark i and one of its candidates a has a weight m_ai = exp(-|v_a - x_i d - t|^2 /
// T) (eq. 8 with zeta = 0); weights that do not fit share theirs with "none of them". The transform
// is the weighted least-squares one, the temperature T falls, the weights harden. It is a local
// method: among much clutter it often ends in a wrong set (docs/method/assignment.md has the
// figures), which it does not notice. The exact search of assignment.h is what the pipeline relies
// on.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/transform2d.h"

namespace orient::interior {

// In whatever unit; the temperatures are that unit squared.
struct SoftassignMark {
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  std::vector<Eigen::Vector2d> candidates;
};

enum class SoftassignModel { kSimilarity, kAffine };

struct SoftassignOptions {
  SoftassignModel model = SoftassignModel::kSimilarity;
  double first_temperature = 217.0 * 217.0;  // (diameter of the search range)^2
  double last_temperature = 1.0;             // (2 sigma0)^2 of a candidate
};

struct SoftassignAnswer {
  std::vector<int> choice;  // per mark: index of its candidate, -1 for none
  Affine2d transform;       // candidate = transform * place, from the last weights
  std::vector<std::vector<double>> first_weights, weights;  // m, per mark and candidate
  int solves = 0;                                           // of the transform
};

// As published, and as its Table 3 was computed: start from the identity, one normalisation a mark
// (its candidates and the outlier sum to 1), one solve a temperature; clean-up: the largest weight
// of a mark, the outlier's included. At most one candidate a mark, but nothing keeps two marks from
// sharing one: their search ranges do not overlap.
SoftassignAnswer SoftassignAsPublished(const std::vector<SoftassignMark>& marks,
                                       const SoftassignOptions& options = {});

// The full method. What differs: alternating normalisation of marks and of candidates, each with an
// outlier of its own, until both hold (Sinkhorn); several solves a temperature, until the transform
// stays; and, as the paper recommends, a similarity down to the last temperature whatever
// options.model says, which only then decides about the transform.
SoftassignAnswer Softassign(const std::vector<SoftassignMark>& marks,
                            const SoftassignOptions& options = {});

}  // namespace orient::interior
