// What an adjusted block hands back. Private to block.
#pragma once

#include "block/bundle/data_snooping.h"
#include "block/bundle/normal_equations.h"

namespace orient::block {

// Poses, points, observations, sigma0 and components, GNSS; with the covariances of `normals`.
// Parts, calibration and cameras are there already.
void FillOutcome(const BlockSystem& system, const BlockJudgement& judgement,
                 const BlockNormals& normals, const BlockTests& tests, BlockResult* result);

// Sums over the rows of one kind that count.
struct KindSums {
  double square = 0, redundancy = 0;
  int rows = 0;
};
std::array<KindSums, kVarianceGroups> SumsOf(const BlockSystem& system, const BlockTests& tests);

// VarianceComponent::group.
const char* GroupName(RowKind kind);

// Groups with less redundancy than this keep their stated variances.
inline constexpr double kLeastGroupRedundancy = 10;

// Held-out control: intersected, projected, compared. Needs the result's photos and cameras.
void FillChecks(const BlockToAdjust& block, BlockResult* result);

}  // namespace orient::block
