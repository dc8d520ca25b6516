#include "block/ties/one_station.h"

#include <gtest/gtest.h>

namespace orient::block {
namespace {

const std::map<std::string, Pose> kPoses = {
    {"p0", {{0, 0, 1000}, {0, 0, 0}}},
    {"p1", {{400, 0, 1000}, {0, 0, 0}}},
    {"copy of p1", {{400.5, 0.5, 1000}, {0, 0, 0}}},  // oriented by itself
    {"p2", {{800, 0, 1000}, {0, 0, 0}}}};

TieRecord TieSeenIn(const std::vector<std::string>& photos) {
  TieRecord tie{{400, 100, 0}, {}};
  for (const std::string& photo : photos)
    tie.seen.push_back({photo, {10, 20}, 0.01 * Eigen::Matrix2d::Identity(), 0.9});
  return tie;
}

std::vector<std::string> PhotosOf(const TieRecord& tie) {
  std::vector<std::string> photos;
  for (const SightingRecord& seen : tie.seen) photos.push_back(seen.photo);
  return photos;
}

using Photos = std::vector<std::string>;

TEST(SplitByStations, APhotoUnderTwoNamesMakesTwoTiesInWhichTheOthersCountOnce) {
  const auto ties = SplitByStations(TieSeenIn({"p0", "p1", "copy of p1", "p2"}), kPoses);
  ASSERT_EQ(ties.size(), 2u);
  EXPECT_EQ(PhotosOf(ties[0]), (Photos{"p0", "p1", "p2"}));
  EXPECT_EQ(PhotosOf(ties[1]), (Photos{"p0", "copy of p1", "p2"}));
  double information_of_p0 = 0, information_of_p1 = 0;
  for (const TieRecord& tie : ties)
    for (const SightingRecord& seen : tie.seen) {
      if (seen.photo == "p0") information_of_p0 += 1 / seen.covariance_px2(0, 0);
      if (seen.photo == "p1") information_of_p1 += 1 / seen.covariance_px2(0, 0);
    }
  EXPECT_NEAR(information_of_p0, 100, 1e-9);
  EXPECT_NEAR(information_of_p1, 100, 1e-9);
}

TEST(SplitByStations, ATieOfAsManyStationsAsRaysStaysAsItIsAndIsNotCopied) {
  EXPECT_TRUE(SplitByStations(TieSeenIn({"p0", "p1", "p2"}), kPoses).empty());
}

TEST(SplitByStations, ATieOfOneStationAloneAndOneOfUnknownPosesStay) {
  EXPECT_TRUE(SplitByStations(TieSeenIn({"p1", "copy of p1"}), kPoses).empty());
  EXPECT_TRUE(SplitByStations(TieSeenIn({"p0", "new", "newer"}), kPoses).empty());
}

}  // namespace
}  // namespace orient::block
