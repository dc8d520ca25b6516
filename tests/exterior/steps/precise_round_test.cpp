#include "exterior/steps/precise_round.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "exterior/orient_photo.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

// The ground in pixels of twice the photo's.
std::vector<patchdb::Patch> CoarsePatches(const TexturedPhoto& world, int n, double step_m) {
  constexpr int kSide = 35;
  std::vector<patchdb::Patch> patches = world.Patches(world.Ground(), n, step_m);
  for (patchdb::Patch& patch : patches) {
    patch.gsd_m *= 2;
    patch.chip = Image(kSide, kSide);
    const Eigen::Vector2d middle = patch.ground_m.head<2>() / TexturedPhoto::kGsd_m;
    for (int row = 0; row < kSide; ++row)
      for (int col = 0; col < kSide; ++col) {
        double sum = 0;
        for (const double x : {-0.5, 0.5})
          for (const double y : {-0.5, 0.5})
            sum += world.Ground().At(
                middle + Eigen::Vector2d(2 * (col + 0.5) - kSide + x, kSide - 2 * (row + 0.5) + y));
        patch.chip.At(col, row) = static_cast<float>(sum / 4);
      }
  }
  return patches;
}

class PreciseRoundOfTexture : public testing::Test {
 protected:
  PreciseRoundOfTexture() {
    photo_.prior.pose = world_.View().pose;
    Vector6d sigma;
    sigma << 3, 3, 3, 0.004, 0.004, 0.004;
    photo_.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  }
  PhotoTask Task() const { return {photo_, world_.File(), patches_, options_}; }
  int Reduction() const {
    return PreciseReduction(
        Task(), {photo_.positions.front(), photo_.prior.pose, photo_.prior.covariance, 0, 1, {}});
  }

  const TexturedPhoto world_{400, HillsAt, false};
  PhotoToOrient photo_ = world_.ToOrient();
  std::vector<patchdb::Patch> patches_ = world_.Patches(world_.Ground(), 2, 130);
  OrientPhotoOptions options_;
};

TEST(APhotoFinerThanItsPatches, IsOkAndItsPrecisionHonest) {
  const TexturedPhoto world(700, HillsAt, false);
  PhotoToOrient photo = world.ToOrient();
  photo.prior.pose = world.View().pose;
  photo.prior.pose.position_m += Eigen::Vector3d(4, -5, 3);
  Vector6d sigma;
  sigma << 6, 6, 6, 0.01, 0.01, 0.01;
  photo.prior.covariance = sigma.cwiseAbs2().asDiagonal();
  const ExteriorResult result =
      OrientPhoto(photo, world.File(), CoarsePatches(world, 3, 150), OrientPhotoOptions());
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  const Vector6d off = PoseDifference(*result.pose, world.View().pose);
  EXPECT_LT(off.head<3>().norm(), 1.5);
  EXPECT_LT(off.dot(result.covariance->ldlt().solve(off)), 22.5);  // 99.9 %
}

TEST_F(PreciseRoundOfTexture, IsAtFullResolutionUnlessThePatchesPixelsAreTwiceAsLarge) {
  EXPECT_EQ(Reduction(), 1);
  const auto with = [&](double factor) {
    patches_ = world_.Patches(world_.Ground(), 2, 130);
    for (patchdb::Patch& patch : patches_) patch.gsd_m *= factor;
    return Reduction();
  };
  EXPECT_EQ(with(0.3), 1) << "finer patches";
  EXPECT_EQ(with(1.5), 1);
  EXPECT_EQ(with(2.0), 2) << "whatever the pose is off by";
  EXPECT_EQ(with(2.5), 2);
  EXPECT_EQ(with(3.2), 3);
  EXPECT_EQ(with(20), 4);
  patches_.clear();
  EXPECT_EQ(Reduction(), 1) << "nothing is visible";
}

TEST_F(PreciseRoundOfTexture, MatchesAtTheResolutionOfCoarserPatchesInPixelsOfTheScan) {
  patches_ = CoarsePatches(world_, 2, 130);
  ASSERT_EQ(Reduction(), 2);
  const PreciseRound round = MatchAll(Task(), world_.View(), photo_.prior.covariance, 4, 2);
  int found = 0;
  for (std::size_t i = 0; i < round.matches.size(); ++i) {
    const PreciseMatch& match = round.matches[i];
    if (!match.found) continue;
    ++found;
    const auto truth = world_.View().PixelFromGround(patches_[round.predictions[i].patch].ground_m);
    const Eigen::Vector2d off = match.pixel - *truth;
    EXPECT_LT(off.norm(), 0.7);
    EXPECT_LT(off.dot(match.covariance_px2.ldlt().solve(off)), 30);
  }
  EXPECT_GE(found, 20);
  EXPECT_EQ(round.margin_px, 8) << "of the scan";
}

TEST_F(PreciseRoundOfTexture, IsAtFullResolutionIfOnlySomePatchesAreCoarser) {
  for (std::size_t i = 0; i < patches_.size(); ++i)
    if (i % 5 < 3) patches_[i].gsd_m *= 2.5;
  EXPECT_EQ(Reduction(), 1) << "the others would become too small";
}

// What lies within a patch of each other is one piece of evidence, and patches are larger there.
TEST(SquareOf, GrowsWithTheReduction) {
  const auto at = [](double x) { return PatchPrediction{0, {x, 10}, Eigen::Matrix2d::Identity()}; };
  EXPECT_NE(SquareOf(at(10), 1), SquareOf(at(100), 1));
  EXPECT_EQ(SquareOf(at(10), 2), SquareOf(at(100), 2));
}

}  // namespace
}  // namespace orient::exterior
