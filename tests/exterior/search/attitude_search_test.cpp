#include "exterior/search/attitude_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/geometry/rotation.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

constexpr int kSide = 260;
constexpr double kStep_m = 95;

// Mountains: a third of the flying height.
double HeightAt(double x, double y) {
  return 100 * std::sin(x / 130) * std::cos(y / 170) + 0.1 * x;
}

// A photo of mountains of which half has changed.
class AttitudeSearch : public testing::Test {
 protected:
  std::vector<patchdb::Patch> PatchesOf(const Texture& texture) const {
    return world_.Patches(texture, 4, kStep_m);
  }

  // A position off by a few per cent of the flying height, and any kappa.
  std::optional<PoseTrack> Search(const std::vector<patchdb::Patch>& patches, double kappa,
                                  const Eigen::Vector2d& tilt = {0, 0}) {
    const Eigen::Vector3d off(20, -15, 25);
    photo_.prior.pose = {view_.pose.position_m + off, {tilt.x(), tilt.y(), kappa}};
    Vector6d sigma;
    sigma << 25, 25, 25, 0.17, 0.17, std::numbers::pi;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
    return SearchAttitudes({photo_, world_.File(), patches, options_}, MedianGroundHeight(patches),
                           100)
        .track;
  }

  double WorstError(const Pose& pose) const {
    return world_.WorstError(pose, PatchesOf(world_.Ground()));
  }

  const TexturedPhoto world_{kSide, HeightAt, true};
  const PhotoView& view_ = world_.View();
  PhotoToOrient photo_ = world_.ToOrient();
  OrientPhotoOptions options_;
};

TEST_F(AttitudeSearch, FindsAnyKappaAndTiltInMountainsOfWhichHalfIsInverted) {
  const auto patches = PatchesOf(world_.Ground());
  const auto track = Search(patches, view_.pose.opk_rad.z() + 2);
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 8);
}

// Aerial photos look down; of an approximation good to ten degrees that says more than its tilt.
TEST_F(AttitudeSearch, FindsWhatIsSaidToBeTiltedByThirtyDegrees) {
  const auto patches = PatchesOf(world_.Ground());
  const auto track = Search(patches, 0, {-0.35, 0.35});
  ASSERT_TRUE(track);
  EXPECT_LT(track->log10_false_alarms, options_.max_log10_false_alarms);
  EXPECT_LT(WorstError(track->pose), 8);
}

TEST_F(AttitudeSearch, IsNotConvincedByPatchesOfAnotherPlace) {
  const auto track = Search(PatchesOf(Texture(6, 6)), 0);
  ASSERT_TRUE(track);
  EXPECT_GT(track->log10_false_alarms, -3);
}

TEST(IsPositionKnown, ToAFewPerCentOfTheFlyingHeight) {
  PosePrior prior{{{0, 0, 2500}, {0, 0, 0}}, Matrix6d::Identity()};
  const auto with = [&](double sigma_m) {
    prior.covariance.topLeftCorner<3, 3>() = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
    return IsPositionKnown(prior, 100);
  };
  EXPECT_TRUE(with(100));
  EXPECT_FALSE(with(300));
  EXPECT_FALSE(IsPositionKnown(prior, 3000));
}

}  // namespace
}  // namespace orient::exterior
