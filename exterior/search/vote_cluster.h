// Votes for a place in a plane, and where most of them meet. Private to exterior.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace orient::exterior {

struct PlaneVote {
  std::size_t voter = 0, candidate = 0;
  Eigen::Vector2d at;
};

// The votes around the one with most voters near it. A voter's votes must be consecutive.
std::vector<PlaneVote> LargestCluster(const std::vector<PlaneVote>& votes, double radius);

// Mean of the votes, of which there must be at least one.
Eigen::Vector2d MeanOf(const std::vector<PlaneVote>& votes);

}  // namespace orient::exterior
