// A first pose made precise by all patches, and whether they confirm it. Private to exterior.
#pragma once

#include <optional>
#include <vector>

#include "core/files/finding.h"
#include "core/files/results.h"
#include "exterior/judge.h"
#include "exterior/steps/photo_task.h"
#include "exterior/steps/precise_round.h"

namespace orient::exterior {

// A refined pose, its rounds, and the evidence for it.
struct SettledPose {
  PoseTrack track;
  std::vector<PreciseRound> rounds;
  JudgedMatches matches;           // if the last round has an estimate
  std::optional<Finding> why_not;  // if the pose is not accepted

  const PreciseRound& Last() const { return rounds.back(); }
};

// Precise rounds at a reduction from a first pose, whose `track` has come down to it. A pose that
// repetitive ground may have led to is compared with another. Where no pose is accepted, the result
// says why.
SettledPose SettlePose(const PhotoTask& task, const PoseTrack& track, int reduction);

// Of a round with an estimate.
LoopRound SummaryOf(const PreciseRound& round);

}  // namespace orient::exterior
