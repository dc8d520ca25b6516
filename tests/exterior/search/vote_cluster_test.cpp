#include "exterior/search/vote_cluster.h"

#include <gtest/gtest.h>

namespace orient::exterior {
namespace {

TEST(LargestCluster, HoldsTheVotesAroundThePlaceThatMostVotersName) {
  const std::vector<PlaneVote> votes = {{0, 0, {0, 0}}, {0, 1, {5, 5}}, {1, 0, {0.4, 0}},
                                        {1, 1, {9, 1}}, {2, 0, {5, 1}}, {3, 0, {0, 0.5}}};
  const auto cluster = LargestCluster(votes, 1);
  ASSERT_EQ(cluster.size(), 3u);
  EXPECT_EQ(cluster[0].voter, 0u);
  EXPECT_EQ(cluster[1].voter, 1u);
  EXPECT_EQ(cluster[2].voter, 3u);
  EXPECT_TRUE(MeanOf(cluster).isApprox(Eigen::Vector2d(0.4 / 3, 0.5 / 3), 1e-12));
}

TEST(LargestCluster, CountsAVoterOnceHoweverManyPlacesItNamesThere) {
  const std::vector<PlaneVote> votes = {
      {0, 0, {0, 0}}, {0, 1, {0.1, 0}}, {0, 2, {0, 0.1}}, {1, 0, {7, 7}}, {2, 0, {7, 7.1}}};
  const auto cluster = LargestCluster(votes, 1);
  ASSERT_EQ(cluster.size(), 2u);
  EXPECT_EQ(cluster[0].voter, 1u);
}

TEST(LargestCluster, OfNoVotesIsEmpty) { EXPECT_TRUE(LargestCluster({}, 1).empty()); }

}  // namespace
}  // namespace orient::exterior
