#include "exterior/search/vote_cluster.h"

namespace orient::exterior {

std::vector<PlaneVote> LargestCluster(const std::vector<PlaneVote>& votes, double radius) {
  std::vector<PlaneVote> best;
  std::size_t most = 0;
  for (const PlaneVote& centre : votes) {
    std::vector<PlaneVote> near;
    std::size_t voters = 0;
    for (const PlaneVote& vote : votes) {
      if ((vote.at - centre.at).norm() > radius) continue;
      if (near.empty() || near.back().voter != vote.voter) ++voters;
      near.push_back(vote);
    }
    if (voters <= most) continue;
    most = voters;
    best = std::move(near);
  }
  return best;
}

Eigen::Vector2d MeanOf(const std::vector<PlaneVote>& votes) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const PlaneVote& vote : votes) sum += vote.at;
  return sum / static_cast<double>(votes.size());
}

}  // namespace orient::exterior
