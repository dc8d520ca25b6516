// Whether one photo's exterior orientation is ok, weak or failed, and why: every reason of the
// stage is decided here.
#pragma once

#include <optional>
#include <string>

#include "core/files/results.h"
#include "exterior/contradicted_sources.h"
#include "exterior/steps/photo_to_orient.h"
#include "exterior/steps/residual_trends.h"

namespace orient::exterior {

// The evidence for and against a pose: what was found before its truth was assumed.
struct JudgedMatches {
  int sought = 0, matched = 0, agreeing = 0;  // patches, by precise matching
  int places = 0;                             // where they agree; patches that overlap are one
  double log10_false_alarms = 0;              // of chance having led to as many
  bool proven_before = false;                 // by the search that led to the pose, at its level
};

// The patches that a failed photo could be searched for with.
struct TriedPatches {
  int visible = 0;                     // patches that it may show
  std::optional<double> side_px = {};  // side of a typical patch in the photo
};

// How well an accepted pose is determined.
struct JudgedPose {
  int places = 0;             // where patches agree
  double spread = 0;          // 1: the agreeing patches lie all over the photo; 0: on a line
  double worst_sigma_px = 0;  // of the projection, in the frame's worst corner
  double target_px = 1;       // what that may be at most
  bool contradicts_prior = false;
  double prior_sigmas = 0;            // how far from the approximation, in its sigmas
  bool prior_counts = false;          // its accuracy was stated
  std::vector<ResidualTrend> trends;  // the largest first
  SourceVotes sources;
};

// log10 of the largest expected number of chance poses at which a pose is accepted: the options'
// limit, or half of that log10 if the search has already proven the pose at its level.
double FalseAlarmLimit(bool proven_before, const OrientPhotoOptions& options);

// The projection sigma stated in the result; empty if unbounded. `ground_pixel_m`: size of a pixel
// on level ground.
std::optional<ProjectionSigma> ProjectionSigmaOf(double worst_sigma_px, double ground_pixel_m);

// What must hold before a pose is given at all; empty: it holds.
std::optional<Finding> WhyNotAccepted(const JudgedMatches& matches,
                                      const OrientPhotoOptions& options);
// Findings about patches that agree with one another but not with the pose.
Findings JudgeSources(const SourceVotes& votes);
// Replaces these findings after a block has changed the pose and which patches are used.
void RejudgeSources(ExteriorResult* result);
// Of an accepted pose: why it is weak, and what else should be known.
Findings Judge(const JudgedPose& pose);

// What to do about a photo that failed, by what was measured: remarks.
Findings Remedies(const TriedPatches& tried);

// Whether a finding concerns precision only: more observations, such as a block's ties, may remedy
// it.
bool ConcernsPrecision(const Finding& finding);

// Why there is no pose. `where`: the patch database.
Finding NoPatches(const std::string& where);
// `complete`: all kappas, heights and places were searched, not as many as are affordable.
Finding NothingAlike(bool complete);
// `round`: the first round, with too few agreeing patches; `wide`: a search of the whole photo, to
// which `complete` (as above) refers.
Finding NoConsensus(const LoopRound& round, bool wide, bool complete);
// No pose by precise matching: of the `sought` patches, `matched` were matched.
Finding NoPreciseResection(int matched, int sought);
// A search of the whole photo that could not be made.
Finding NotSearchedAsAWhole();

// Adds a finding; the status becomes at best what the finding allows.
void Add(const Finding& finding, ExteriorResult* result);

}  // namespace orient::exterior
