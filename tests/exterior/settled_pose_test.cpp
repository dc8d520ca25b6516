#include "exterior/settled_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <vector>

#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

// From a first pose that is off by two pixels and proven, of patches of a texture.
class SettledPoseOfTexture : public testing::Test {
 protected:
  SettledPose Settled(const Texture& texture, int reduction) const {
    PhotoToOrient photo = world_.ToOrient();
    photo.prior = {world_.View().pose, 100 * Matrix6d::Identity()};
    const std::vector<patchdb::Patch> patches = world_.Patches(texture, 2, 130);
    PoseTrack track;
    track.position = photo.positions.front();
    track.pose = world_.View().pose;
    track.pose.position_m += 2 * TexturedPhoto::kGsd_m * Eigen::Vector3d::UnitX();
    Vector6d sigma;
    sigma << 4, 4, 4, 0.005, 0.005, 0.005;
    track.covariance = sigma.cwiseAbs2().asDiagonal();
    track.log10_false_alarms = -20;
    track.reduction = 2;
    return SettlePose({photo, world_.File(), patches, {}}, track, reduction);
  }

  double Off_px(const SettledPose& pose) const {
    return world_.WorstError(pose.track.pose, world_.Patches(world_.Ground(), 2, 130));
  }

  const TexturedPhoto world_{400, HillsAt, false};
};

TEST_F(SettledPoseOfTexture, IsRightWithinAFractionOfAPixel) {
  const SettledPose pose = Settled(world_.Ground(), 1);
  ASSERT_FALSE(pose.why_not) << Sentence(*pose.why_not);
  EXPECT_LT(Off_px(pose), 0.2);
  EXPECT_GE(pose.matches.agreeing, 20);
  EXPECT_TRUE(pose.matches.proven_before);
}

TEST_F(SettledPoseOfTexture, StatesTheReductionOfItsRounds) {
  for (const int reduction : {1, 2}) {
    const SettledPose pose = Settled(world_.Ground(), reduction);
    ASSERT_TRUE(pose.Last().estimate);
    EXPECT_EQ(SummaryOf(pose.Last()).reduction, reduction);
    EXPECT_EQ(pose.track.rounds.back().reduction, reduction);
    EXPECT_EQ(pose.track.rounds.back().matched, pose.matches.agreeing);
  }
}

TEST_F(SettledPoseOfTexture, SaysWhyPatchesOfElsewhereConfirmNone) {
  const SettledPose pose = Settled(Texture(6, 6), 1);
  ASSERT_TRUE(pose.why_not);
  EXPECT_EQ(pose.why_not->at_best, Status::kFailed);
  EXPECT_FALSE(pose.rounds.empty());
}

}  // namespace
}  // namespace orient::exterior
