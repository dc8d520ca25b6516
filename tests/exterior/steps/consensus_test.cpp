#include "exterior/steps/consensus.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/collinearity.h"
#include "tests/exterior/digital_view.h"
#include "tests/support/shared_data.h"

namespace orient::exterior {
namespace {

constexpr double kNoisePx = 0.5;

// A vertical photo over rolling ground, a prior that is off, and patches that vote.
struct Scene {
  PhotoView truth;
  PosePrior prior;
  std::vector<VotingPatch> patches;
};

Scene MakeScene(int patch_count, double share_true, int clutter, unsigned seed, bool flat = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> normal;
  Scene scene;
  scene.truth = DigitalView();
  Vector6d sigma;
  sigma << 150, 150, 150, 0.035, 0.035, 0.035;
  Vector6d off = sigma;
  for (int i = 0; i < 6; ++i) off[i] *= 0.8 * normal(random);
  scene.prior = {Pose::FromVector(scene.truth.pose.AsVector() + off),
                 sigma.cwiseAbs2().asDiagonal()};
  while (static_cast<int>(scene.patches.size()) < patch_count) {
    VotingPatch patch;
    patch.ground_m = {1000 + 2500 * unit(random), 2000 + 2500 * unit(random),
                      flat ? 300.0 : 400 + 200 * unit(random)};
    const auto pixel = scene.truth.PixelFromGround(patch.ground_m);
    PhotoView predicted = scene.truth;
    predicted.pose = scene.prior.pose;
    const auto expected = predicted.PixelFromGround(patch.ground_m);
    if (!pixel || pixel->x() < 0 || pixel->x() > 640 || pixel->y() < 0 || pixel->y() > 1152)
      continue;
    constexpr double kRadius = 120;
    patch.window_px2 = 4 * kRadius * kRadius;
    for (int k = 0; k < clutter; ++k)
      patch.candidates.push_back(
          {*expected + kRadius * Eigen::Vector2d(unit(random), unit(random)), 0.5});
    if (0.5 * (unit(random) + 1) < share_true) {
      const Candidate right{*pixel + kNoisePx * Eigen::Vector2d(normal(random), normal(random)),
                            0.6};
      const auto place = patch.candidates.begin() + static_cast<long>(random() % (clutter + 1u));
      patch.candidates.insert(place, right);
    }
    scene.patches.push_back(patch);
  }
  return scene;
}

double LargestErrorPx(const Scene& scene, const Pose& pose) {
  PhotoView view = scene.truth;
  view.pose = pose;
  double largest = 0;
  for (const VotingPatch& patch : scene.patches)
    largest = std::max(largest, (*view.PixelFromGround(patch.ground_m) -
                                 *scene.truth.PixelFromGround(patch.ground_m))
                                    .norm());
  return largest;
}

TEST(Consensus, FindsThePoseAmongFourTimesAsMuchClutter) {
  for (unsigned run = 0; run < 10; ++run) {
    const Scene scene = MakeScene(100, 0.5, 4, TestSeed() + run);
    const auto found = FindConsensus(scene.truth, scene.prior, scene.patches, {});
    ASSERT_TRUE(found);
    EXPECT_LT(found->log10_false_alarms, -6);
    EXPECT_LT(LargestErrorPx(scene, found->pose), 4 * kNoisePx);
  }
}

TEST(Consensus, RandomCandidatesAreNeverSignificant) {
  for (unsigned run = 0; run < 20; ++run) {
    const Scene scene = MakeScene(100, 0.0, 5, TestSeed() + run);
    const auto found = FindConsensus(scene.truth, scene.prior, scene.patches, {});
    ASSERT_TRUE(found);
    EXPECT_GT(found->log10_false_alarms, -6);
  }
}

TEST(Consensus, FlatGroundIsHeldByThePrior) {
  const Scene scene = MakeScene(60, 0.6, 3, TestSeed(), true);
  const auto found = FindConsensus(scene.truth, scene.prior, scene.patches, {});
  ASSERT_TRUE(found);
  EXPECT_LT(LargestErrorPx(scene, found->pose), 4 * kNoisePx);
}

TEST(Consensus, TwoPatchesAreNoConsensus) {
  const Scene scene = MakeScene(2, 1.0, 0, TestSeed());
  EXPECT_FALSE(FindConsensus(scene.truth, scene.prior, scene.patches, {}));
}

TEST(Consensus, SameSeedGivesTheSamePose) {
  const Scene scene = MakeScene(80, 0.5, 4, TestSeed());
  const auto first = FindConsensus(scene.truth, scene.prior, scene.patches, {});
  const auto second = FindConsensus(scene.truth, scene.prior, scene.patches, {});
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->pose.AsVector(), second->pose.AsVector());
}

TEST(FalseAlarms, FallWithSupportersAndRiseWithProbability) {
  EXPECT_LT(Log10FalseAlarms(100, 40, 5, 0.01), Log10FalseAlarms(100, 30, 5, 0.01));
  EXPECT_LT(Log10FalseAlarms(100, 30, 5, 0.01), Log10FalseAlarms(100, 30, 5, 0.1));
  EXPECT_GE(Log10FalseAlarms(100, 3, 5, 0.01), 0);
}

TEST(FalseAlarms, AnExpectedNumberOfSupportersIsNoEvidence) {
  EXPECT_GT(Log10FalseAlarms(100, 10, 5, 0.1), 0);
}

}  // namespace
}  // namespace orient::exterior
