// What the searches for a first pose share (keypoint_search.h, wide_search.h, first_pose.h): which
// of two poses is better, and for a whole photo the order in which ways to take it are tried, and
// the best followed up. Private to exterior.
#pragma once

#include <array>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "exterior/search/vote_cluster.h"
#include "exterior/steps/consensus.h"
#include "exterior/steps/photo_task.h"

namespace orient::exterior {

inline constexpr int kKappas = 24;
inline constexpr double kKappaStep_rad = 2 * std::numbers::pi / kKappas;

// 0, 1, -1, 2, -2, ...
inline int Outwards(int i) { return i % 2 == 0 ? -i / 2 : (i + 1) / 2; }

double MedianGroundHeight(const std::vector<patchdb::Patch>& patches);

// How the image sought lies in the scan, rounded: film rotated by 90 degrees with kappa rotated
// back looks the same.
using Look = std::array<long, 4>;

// Under a camera that looks down. In hundredths.
Look LookOf(const FilmPosition& position, double kappa_rad);

// Whether `a` is less likely to be due to chance.
inline bool IsBetter(const PoseTrack& a, const PoseTrack& b) {
  return a.log10_false_alarms < b.log10_false_alarms;
}

// Whether it is unlikely enough to be due to chance.
inline bool Convinces(const std::optional<PoseTrack>& track, const OrientPhotoOptions& options) {
  return track && track->log10_false_alarms < options.max_log10_false_alarms;
}

// Moves `track` to `*best` if there is one and it is better than what was there.
void KeepBetter(std::optional<PoseTrack> track, std::optional<PoseTrack>* best);

// What a search of the whole photo may cost: in correlated pixels of its level, not in seconds, so
// that a photo ends the same on every machine.
class SearchBudget {
 public:
  explicit SearchBudget(double pixels) : left_(pixels) {}
  void Spend(const std::vector<VotingPatch>& sought, int reduction);
  bool Spent() const { return left_ <= 0; }

 private:
  double left_;
};

// Ways the photo may have been taken, by their index.
struct WaysToTry {
  std::size_t count = 0;
  std::function<Look(std::size_t)> look;
  std::function<std::optional<PoseTrack>(std::size_t)> first;
  // Under the pose that it led to.
  std::function<std::optional<PoseTrack>(std::size_t, const PoseTrack&)> again;
  std::size_t followed = 0;  // so many of the best are tried again, all of another look
  double max_log10_false_alarms = 0;
  const SearchBudget* budget = nullptr;  // once it is spent no further way is tried
};
inline constexpr int kFollowedRounds = 2;

// The first that convinces, else the best; empty where no way gives a pose.
std::optional<PoseTrack> TryWays(const WaysToTry& ways);

// Changes to the equivalent film position that the prior's kappa clearly prefers, if any. If the
// marks are alike, nothing else distinguishes rotated film from a camera rotated the other way.
void LetPriorDecidePosition(const std::vector<FilmPosition>& positions, const PosePrior& prior,
                            FilmPosition* position, Pose* pose);

// Number of the photo's film positions, this one included, that give the same image with another
// kappa and are not clearly less likely by the prior.
int EquallyLikelyPositions(const PhotoToOrient& photo, const FilmPosition& position,
                           double kappa_rad);

// Result of a search of the whole photo; whether there was one at all, and whether it covered all
// hypotheses: what was not searched cannot have been found.
struct WholePhotoSearch {
  std::optional<PoseTrack> track = {};
  bool searched = false;
  bool complete = true;

  void Add(WholePhotoSearch another);
};

// What is needed to take a cluster of votes for a pose.
struct ClusterConsensus {
  const std::vector<VotingPatch>& voting;
  const std::vector<PlaneVote>& cluster;  // of votes of their candidates
  const ConsensusOptions& options;
};

// The consensus among the cluster's candidates; its false alarms count all that might have agreed.
std::optional<Consensus> FindConsensus(const PhotoView& view, const PosePrior& prior,
                                       const ClusterConsensus& of);

// The consensus among `sought` patches, of a search of the whole photo at a reduction.
PoseTrack TrackOf(const PhotoTask& task, const FilmPosition& position, const Consensus& consensus,
                  std::size_t sought, int reduction, double trials);

}  // namespace orient::exterior
