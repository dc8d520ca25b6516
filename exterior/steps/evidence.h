// What the precise matches prove: whether chance could have made as many agree. Private
// to exterior.
#pragma once

#include <vector>

#include "exterior/steps/precise_round.h"

namespace orient::exterior {

inline constexpr int kFewestAgreeing = 6;  // with fewer no pose is accepted

// Patches that overlap show the same ground and are one piece of evidence: counted is the number of
// squares of a patch's size that contain any.
struct Evidence {
  int sought = 0, agreeing = 0;
};

// A patch agrees if it does so in this round and still in the last one.
Evidence CountEvidence(const PreciseRound& round, const PreciseRound& last);

// log10 of how many such agreements chance is expected to make, in the round that proves most. As
// if every patch were found somewhere in its window; where that proves less than `enough`, with the
// frequency with which decoys (MatchDecoys) are found.
double LeastFalseAlarms(const PhotoTask& task, const std::vector<PreciseRound>& rounds,
                        double enough);

}  // namespace orient::exterior
