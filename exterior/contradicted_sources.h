// Sources of patches that contradict a pose as a whole. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/files/results.h"

namespace orient::exterior {

// Its patches agree with one another and lie elsewhere than the pose shows them.
struct ContradictedSource {
  std::int64_t source = 0;
  int found = 0, used = 0;   // patches
  Eigen::Vector2d shift_px;  // median residual of those not used: measured - computed
};

// Patches of sources that do not contradict it as a whole, as where a mosaic's parts do not fit.
struct PatchesElsewhere {
  int patches = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // their mean residual: measured - computed
};

struct SourceVotes {
  std::vector<ContradictedSource> contradicted;
  int agreeing_sources = 0;  // of whose patches most are used
  int used = 0;              // patches, of all sources
  // Twelve or more, a twentieth of those used, that lie together in the photo.
  PatchesElsewhere elsewhere;
};

// Of a photo's patches with their residuals. A source has a say with twelve patches that were
// found. It is contradicted where most of them are not used, and most of those lie around their
// median shift, closer than half of it.
SourceVotes VotesOf(const std::vector<PatchResult>& results);

// Whether nothing tells which of two sources is wrong: as many contradict the pose as agree with
// it, with a fifth of the patches it rests on, at least.
bool IsUndecided(const SourceVotes& votes);

// The same of patches that agree elsewhere, whatever their sources: a tenth of those used.
bool IsUndecided(const PatchesElsewhere& elsewhere, int used);

}  // namespace orient::exterior
