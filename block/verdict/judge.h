// Whether a photo of an adjusted block is ok, weak or failed, and why: every reason of the stage is
// decided here.
#pragma once

#include <optional>
#include <string>

#include "block/verdict/own_patches.h"
#include "core/files/results.h"

namespace orient::block {

// What the adjustment says of one photo.
struct TiedPhoto {
  int ties_used = 0;
  int comparable = 0;         // of the measured ties: another photo's ray could contradict
  double tie_redundancy = 0;  // of the used ones together
  double worst_sigma_px = 0;  // of the adjusted pose's projection, in the frame's worst corner
  double target_px = 1;       // what that may be at most in a photo that is ok
  double moved_chi2 = 0;      // from where its own patches put it; six degrees of freedom
  OwnPatches own = {};        // where they are held off the pose that is in worst_sigma_px
  int control_elsewhere = 0;  // points and patches used in its part that it does not show itself
};

// Oriented by measured points that are too few, too imprecise or unchecked to be believed alone.
bool IsByFewPoints(const Finding& finding);

// Ties enough, more than half of them contradicting the pose.
bool TiesContradict(const TiedPhoto& photo);
Finding TiesContradictFinding(Status at_best);

// Of a photo without control of its own: what its ties leave open. A pose is given unless one of
// them is a failure.
Findings JudgeTied(const TiedPhoto& photo);

// Of a photo that has a pose by its own patches: objections to its pose in the block.
Findings JudgeAgainstOwnPatches(const TiedPhoto& photo);

// A photo that was weak only for its precision is judged by that of the block, if it comes from
// ties and not only from the same few patches. Where that of the block is poor, too, it is the only
// one told. So is one that was oriented by few measured points, if there is control enough besides:
// otherwise that there is not is told, instead of what the points alone say of another pose.
void LiftImprecision(const TiedPhoto& photo, ExteriorResult* result);

// `adjusted` by GNSS and approximations as observations, too; `held` without them. These make no
// photo better than it is without.
void HoldTo(const ExteriorResult& held, ExteriorResult* adjusted);

}  // namespace orient::block
