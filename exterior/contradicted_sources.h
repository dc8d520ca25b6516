// Sources of patches that contradict a pose as a whole. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/files/results.h"

namespace orient::exterior {

// A source whose patches agree with one another but lie elsewhere than the pose projects them.
struct ContradictedSource {
  std::int64_t source = 0;
  int found = 0, used = 0;   // patches
  Eigen::Vector2d shift_px;  // median residual of those not used: measured - computed
};

// Patches displaced alike, of sources not contradicted as a whole, e.g. a mosaic's shifted part.
struct PatchesElsewhere {
  int patches = 0;
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();  // their mean residual: measured - computed
};

struct SourceVotes {
  std::vector<ContradictedSource> contradicted;
  int agreeing_sources = 0;  // sources most of whose patches are used
  int used = 0;              // patches, of all sources
  // Twelve or more, a twentieth of those used, that lie together in the photo.
  PatchesElsewhere elsewhere;
};

// From a photo's patch results with residuals. A source counts if at least twelve of its patches
// were found. It is contradicted if at most half of them are used and most of the others lie
// within half the length of their median shift from that shift. `reduction`: at which they were
// matched.
SourceVotes VotesOf(const std::vector<PatchResult>& results, int reduction);

// Whether nothing tells which of two sources is wrong: as many contradict the pose as agree with
// it, with a fifth of the patches it rests on, at least.
bool IsUndecided(const SourceVotes& votes);

// The same of patches that agree elsewhere, whatever their sources: a tenth of those used.
bool IsUndecided(const PatchesElsewhere& elsewhere, int used);

}  // namespace orient::exterior
