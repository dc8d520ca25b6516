#include "exterior/search/sought_patches.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

class SoughtPatchesOfTexture : public testing::Test {
 protected:
  std::optional<SoughtPatches> Of(const Pose& approximate) {
    return SoughtPatches::Of(task_, 0, approximate, &level_);
  }
  Pose From(double height_m) const {
    Pose pose = view_.pose;
    pose.position_m.z() = height_m;
    return pose;
  }

  const TexturedPhoto world_{260, [](double, double) { return 0.0; }, false};
  const PhotoView& view_ = world_.View();
  const PhotoToOrient photo_ = world_.ToOrient();
  OrientPhotoOptions options_;
  const std::vector<patchdb::Patch> patches_ = world_.Patches(world_.Ground(), 5, 50);
  const PhotoTask task_{photo_, world_.File(), patches_, options_};
  std::shared_ptr<const PhotoLevel> level_;
};

TEST_F(SoughtPatchesOfTexture, AreSixtyAndFoundWhereTheyLie) {
  constexpr double kNear_px = 6;  // three pixels of the level
  const auto sought = Of(view_.pose);
  ASSERT_TRUE(sought);
  Vector6d sigma;
  sigma << 5, 5, 5, 0.02, 0.02, 0.1;
  const PosePrior prior{view_.pose, sigma.cwiseAbs2().asDiagonal()};
  const std::vector<VotingPatch> voting = sought->Seek(view_, prior);
  EXPECT_EQ(voting.size(), 60u);
  int found = 0, seen = 0;
  for (const VotingPatch& patch : voting) {
    const Eigen::Vector2d truth = *view_.PixelFromGround(patch.ground_m);
    const bool inside = ((truth.array() > 30) && (truth.array() < 230)).all();
    seen += inside ? 1 : 0;
    if (inside && !patch.candidates.empty() &&
        (patch.candidates.front().pixel - truth).norm() < kNear_px)
      ++found;
  }
  EXPECT_GT(seen, 20);
  EXPECT_GT(found, 0.9 * seen);
}

TEST_F(SoughtPatchesOfTexture, FromAnotherPoseShareTheLevelUnlessItMustBeAnother) {
  ASSERT_TRUE(Of(view_.pose));
  const auto first = level_;
  ASSERT_TRUE(Of({view_.pose.position_m, {0, 0, 1}}));
  EXPECT_EQ(level_, first);
  ASSERT_TRUE(Of(From(0.5 * view_.pose.position_m.z())));
  EXPECT_NE(level_, first) << "from half the height they are twice as large";
}

TEST_F(SoughtPatchesOfTexture, OutOfSightAreNone) {
  Pose elsewhere = view_.pose;
  elsewhere.position_m.x() += 10000;
  EXPECT_FALSE(Of(elsewhere));
  EXPECT_FALSE(level_);
}

}  // namespace
}  // namespace orient::exterior
