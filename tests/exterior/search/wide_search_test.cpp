#include "exterior/search/wide_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "exterior/search/first_pose.h"
#include "exterior/search/keypoint_search.h"
#include "exterior/search/search_prior.h"
#include "exterior/search/whole_photo_search.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

constexpr double kFlyingHeight_m = 800;

// So many that tiles of them can be sought; cut once for all tests.
const std::vector<patchdb::Patch>& DensePatches() {
  static const std::vector<patchdb::Patch> patches =
      PhotoOfHills().Patches(PhotoOfHills().Ground(), 10, 60);
  return patches;
}

// The photo at another kappa, with a position said to be good to some metres.
class SearchedWidely : public testing::Test {
 protected:
  SearchedWidely() { Approximate(20); }

  void Approximate(double sigma_m) {
    photo_.prior.pose = PhotoOfHills().View().pose;
    photo_.prior.pose.position_m += Eigen::Vector3d(15, -10, 12);
    photo_.prior.pose.opk_rad = {0, 0, photo_.prior.pose.opk_rad.z() + 2};
    Vector6d sigma;
    sigma << sigma_m, sigma_m, 20, 0.05, 0.05, std::numbers::pi;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  }
  PhotoTask Task() const { return {photo_, PhotoOfHills().File(), patches_, options_}; }
  double WorstError(const Pose& pose) const { return PhotoOfHills().WorstError(pose, patches_); }
  // Three scales, 24 kappas and all film positions, and two of each followed up twice at most.
  double TileTrials() const {
    return 3.0 * kKappas * static_cast<double>(photo_.positions.size()) * (1 + 2 * 2);
  }
  double AllTrials() const { return TileTrials() + KeypointTrials(Task()); }

  void ExpectNotSearched() const {
    const WholePhotoSearch search = SearchWidely(Task());
    EXPECT_FALSE(search.searched);
    EXPECT_FALSE(search.track);
  }

  PhotoToOrient photo_ = PhotoOfHills().ToOrient();
  OrientPhotoOptions options_;
  std::vector<patchdb::Patch> patches_ = DensePatches();
};

TEST_F(SearchedWidely, APhotoWhosePositionIsKnownIsFoundByItsKeypointsAndAllSearchesCount) {
  const auto track = SearchWidely(Task()).track;
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 5);
  EXPECT_EQ(track->trials, AllTrials() + KappaTrials(Task()));
  const auto by_keypoints =
      SearchByKeypoints(Task(), MedianGroundHeight(patches_), track->trials).track;
  ASSERT_TRUE(by_keypoints);
  EXPECT_EQ(track->pose.AsVector(), by_keypoints->pose.AsVector());
}

TEST_F(SearchedWidely, APhotoWhosePositionIsNotKnownIsFound) {
  Approximate(0.09 * kFlyingHeight_m);
  const auto track = SearchWidely(Task()).track;
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 12);
  EXPECT_EQ(track->trials, AllTrials());
}

TEST_F(SearchedWidely, EveryFilmPositionCounts) {
  Approximate(0.09 * kFlyingHeight_m);
  photo_.positions.push_back(photo_.positions.front());
  const auto track = SearchWidely(Task()).track;
  ASSERT_TRUE(track);
  EXPECT_EQ(track->trials, AllTrials());
  EXPECT_EQ(TileTrials(), 2 * 360);
}

TEST_F(SearchedWidely, APhotoOfAnotherPlaceDoesNotConvince) {
  patches_ = PhotoOfHills().Patches(Texture(6, 6), 10, 60);
  const auto track = SearchWidely(Task()).track;
  if (track) {
    EXPECT_GT(track->log10_false_alarms, options_.max_log10_false_alarms);
  }
}

// A few small patches cannot be assembled into tiles, nor do their chips show keypoints.
TEST_F(SearchedWidely, FewSmallPatchesAndAnUnknownPositionAreNotSought) {
  patches_.resize(3);
  for (patchdb::Patch& patch : patches_) {
    patch.chip.values.resize(21 * 21);
    patch.chip.width = patch.chip.height = 21;
  }
  Approximate(0.09 * kFlyingHeight_m);
  ExpectNotSearched();
}

TEST_F(SearchedWidely, APhotoFromBelowTheGroundIsNotSought) {
  photo_.prior.pose.position_m.z() = -50;
  ExpectNotSearched();
  photo_.prior.pose.position_m.z() = MedianGroundHeight(patches_);
  ExpectNotSearched();
}

// A photo of mountains, a third of the flying height high, of which half has changed.
class MountainsSearchedWidely : public testing::Test {
 protected:
  static double HeightAt(double x, double y) {
    return 100 * std::sin(x / 130) * std::cos(y / 170) + 0.1 * x;
  }

  std::vector<patchdb::Patch> PatchesOf(const Texture& texture) const {
    return world_.Patches(texture, 4, 95);
  }

  // From a position off by a few per cent of the flying height, and any kappa.
  std::optional<PoseTrack> Search(const std::vector<patchdb::Patch>& patches, double kappa) {
    const Eigen::Vector3d off(20, -15, 25);
    photo_.prior.pose = {world_.View().pose.position_m + off, {0, 0, kappa}};
    Vector6d sigma;
    sigma << 25, 25, 25, 0.17, 0.17, std::numbers::pi;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
    return SearchWidely({photo_, world_.File(), patches, options_}).track;
  }

  double WorstError(const Pose& pose) const {
    return world_.WorstError(pose, PatchesOf(world_.Ground()));
  }

  const TexturedPhoto world_{260, HeightAt, true};
  PhotoToOrient photo_ = world_.ToOrient();
  OrientPhotoOptions options_;
};

TEST_F(MountainsSearchedWidely, AreFoundAtAnyKappa) {
  const auto track = Search(PatchesOf(world_.Ground()), world_.View().pose.opk_rad.z() + 2);
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 12);
}

TEST_F(MountainsSearchedWidely, DoNotConvinceOfAnotherPlace) {
  const auto track = Search(PatchesOf(Texture(6, 6)), 0);
  if (track) {
    EXPECT_GT(track->log10_false_alarms, -3);
  }
}

// Chips too small for keypoints in a photo too large for windows that wide: tiles remain.
TEST(SlowSearchedWidely, ByTilesWhereThePositionIsKnownButAllWindowsAreTooLarge) {
  constexpr int kSide = 1300, kChip = 21;
  const TexturedPhoto world(kSide, HillsAt, false);
  PhotoToOrient photo = world.ToOrient();
  photo.prior.pose = world.View().pose;
  Vector6d sigma;
  sigma << 5, 5, 5, 0.35, 0.35, std::numbers::pi;
  photo.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  std::vector<patchdb::Patch> patches = world.Patches(world.Ground(), 30, 38);
  for (patchdb::Patch& patch : patches) {
    Image chip(kChip, kChip);
    const int margin = (patch.chip.width - kChip) / 2;
    for (int row = 0; row < kChip; ++row)
      for (int col = 0; col < kChip; ++col)
        chip.At(col, row) = patch.chip.At(col + margin, row + margin);
    patch.chip = std::move(chip);
  }
  const OrientPhotoOptions options;
  const PhotoTask task{photo, world.File(), patches, options};
  const double ground_m = MedianGroundHeight(patches);
  ASSERT_TRUE(IsPositionKnown(photo.prior, ground_m));
  ASSERT_FALSE(SearchByKeypoints(task, ground_m, 1).searched);
  ASSERT_FALSE(FirstPoseByKappa(task, 1).searched);
  const WholePhotoSearch search = SearchWidely(task);
  EXPECT_TRUE(search.searched);
  ASSERT_TRUE(search.track);
  EXPECT_LT(search.track->log10_false_alarms, options.max_log10_false_alarms);
}

}  // namespace
}  // namespace orient::exterior
