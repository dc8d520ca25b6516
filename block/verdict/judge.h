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
  int comparable = 0;         // measured ties that another photo's ray could contradict
  double tie_redundancy = 0;  // of the used ones together
  double worst_sigma_px = 0;  // of the adjusted pose's projection, in the frame's worst corner
  double target_px = 1;       // what that may be at most in a photo that is ok
  double moved_chi2 = 0;      // from where its own patches put it; six degrees of freedom
  OwnPatches own = {};        // if the pose is held off them, worst_sigma_px includes that
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

// A photo that was weak only for its precision is judged by its precision in the block, if that is
// due to ties and not only to the same few patches. If the block's is poor, too, only that is
// reported. Likewise a photo oriented by few measured points, if there is enough other control: if
// not, that lack is reported instead of what the points alone say about another pose.
void RejudgePrecision(const TiedPhoto& photo, ExteriorResult* result);

// `adjusted` by GNSS and approximations as observations, too; `held` without them. These make no
// photo better than it is without.
void HoldTo(const ExteriorResult& held, ExteriorResult* adjusted);

}  // namespace orient::block
