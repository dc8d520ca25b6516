// Step 4, resect, first half: the pose that explains the most candidates, and whether chance could
// have produced it.
//
// A wrong pose moves all patches together, so the patches vote: poses from small samples of
// candidates and the prior (a sample of three on near-coplanar or one-sided ground would leave the
// pose open, the prior closes it), scored by how many patches have a candidate where the pose says.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/resection.h"
#include "core/terrain/photo_view.h"
#include "exterior/steps/match.h"

namespace orient::exterior {

struct VotingPatch {
  Eigen::Vector3d ground_m;
  std::vector<Candidate> candidates;
  double window_px2 = 0;  // the area that was searched
};

struct ConsensusOptions {
  double sigma_px = 1.0;  // of a right candidate at this reduction, one coordinate
  int samples = 3000;
  int iterations = 3;  // of a sample's pose, from view.pose
  // How many searches like this one are made before the best of them is believed.
  double trials = 1;
  std::uint32_t seed = 1;
};

struct Supporter {
  std::size_t patch = 0;
  std::size_t candidate = 0;
};

struct Consensus {
  Pose pose;
  Matrix6d covariance;  // of the prior and the supporters together
  std::vector<Supporter> supporters;
  double rms_px = 0;
  // log10 of the expected number of such consensuses among candidates that lie at random.
  double log10_false_alarms = 0;
};

// Poses are searched for from view.pose on, the prior may lie elsewhere. Empty when fewer than
// three patches have candidates, or no sample gives a pose.
std::optional<Consensus> FindConsensus(const PhotoView& view, const PosePrior& prior,
                                       const std::vector<VotingPatch>& patches,
                                       const ConsensusOptions& options);

// The bound that a consensus carries, for supporters among candidates other than those it was found
// in.
double Log10FalseAlarms(const std::vector<VotingPatch>& patches,
                        const std::vector<Supporter>& supporters, const ConsensusOptions& options);

// Upper bound (Chernoff) of log10 of the expected number of poses, among all that `patches` patches
// with `candidates` each can propose, that `supporters` patches support by chance, when each does
// so with probability `p`.
double Log10FalseAlarms(int patches, int supporters, double candidates, double p);

}  // namespace orient::exterior
