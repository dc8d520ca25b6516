// What estimators of one pose take from observations that share errors: fewer of them, and how the
// height errors under any two go together. Internal to exterior.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "exterior/steps/observation.h"

namespace orient::exterior {

// Every k-th, so that at most 250 remain: more share their errors and add nothing.
std::vector<PatchObservation> Thinned(const std::vector<PatchObservation>& all);

// Correlation of the height errors under any two observations, each twice for col and row.
Eigen::MatrixXd HeightCorrelation(const std::vector<PatchObservation>& observations,
                                  double length_m);

}  // namespace orient::exterior
