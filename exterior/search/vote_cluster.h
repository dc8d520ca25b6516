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

// The votes around that one which most voters agree with. A voter's votes stand together.
std::vector<PlaneVote> LargestCluster(const std::vector<PlaneVote>& votes, double radius);

// Of votes there are: their mean.
Eigen::Vector2d MeanOf(const std::vector<PlaneVote>& votes);

}  // namespace orient::exterior
