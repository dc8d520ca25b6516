// Blocks that cannot be adjusted, wholly or in part: said, never guessed and never a crash.
#include <gtest/gtest.h>

#include <algorithm>

#include "block/bundle/adjustment.h"
#include "block/bundle/data_snooping.h"
#include "tests/block/bundle/bundle_verdict.h"

namespace orient::block {
namespace {

BundleSimulationOptions TwoStrips(bool prior) {
  BundleSimulationOptions options;
  options.strips = 2;
  options.photos_in_strip = 4;
  options.ties_per_photo = 40;
  options.control_photos = {0, 3};
  options.prior = prior;
  return options;
}

// Keeps the observations that `keep` wants.
template <typename Keep>
void Thin(BundleSimulation* simulation, const Keep& keep) {
  std::vector<ImageObservation> kept;
  for (const ImageObservation& o : simulation->block.observations)
    if (keep(o)) kept.push_back(o);
  simulation->block.observations = kept;
  simulation->gross.assign(kept.size(), false);
}

// No point is seen in both strips.
void PartStrips(BundleSimulation* simulation) {
  std::vector<int> strip(simulation->block.points.size(), -1);
  Thin(simulation, [&](const ImageObservation& o) {
    const int here = o.photo < 4 ? 0 : 1;
    if (strip[o.point] < 0) strip[o.point] = here;
    return strip[o.point] == here;
  });
}

// The photos of which it is said.
std::string SaidOf(const BlockResult& result, Reason reason) {
  for (const Finding& finding : result.findings)
    if (finding.reason == reason) return finding.where;
  return "nobody";
}

TEST(BlockDegenerate, UnconnectedPartsAreNamedAndTheOneWithControlIsAdjusted) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(false));
  PartStrips(&simulation);
  const BlockResult result = AdjustBlock(simulation.block);
  ASSERT_EQ(result.parts.size(), 2u);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(result.photos[i].state, i < 4 ? PhotoState::kAdjusted : PhotoState::kNoDatum);
  EXPECT_TRUE(result.parts[0].has_datum);
  EXPECT_TRUE(result.parts[0].by_control);
  EXPECT_FALSE(result.parts[1].has_datum);
  EXPECT_EQ(SaidOf(result, Reason::kPartNotConnected), "s0_0, s0_1, s0_2 and s0_3");
  EXPECT_EQ(SaidOf(result, Reason::kPartWithoutDatum), "s1_0, s1_1, s1_2 and s1_3");
  EXPECT_LT(JudgeBundle(simulation, result).height_gsd, 1.5);
}

TEST(BlockDegenerate, AStripWithoutControlHangsOnItsApproximationsAndThatIsSaid) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(true));
  PartStrips(&simulation);
  const BlockResult result = AdjustBlock(simulation.block);
  ASSERT_EQ(result.parts.size(), 2u);
  EXPECT_TRUE(result.parts[0].by_control);
  EXPECT_FALSE(result.parts[1].by_control);
  EXPECT_EQ(result.parts[1].control_points, 0);
  EXPECT_EQ(SaidOf(result, Reason::kPartWithoutControl), "s1_0, s1_1, s1_2 and s1_3");
  for (std::size_t i = 4; i < 8; ++i) {
    EXPECT_EQ(result.photos[i].state, PhotoState::kAdjusted);
    EXPECT_GT(std::sqrt(result.photos[i].covariance(0, 0)), 0.5);  // the prior says 3 m
  }
}

TEST(BlockDegenerate, ABlockWithoutAnyDatumIsNotAdjusted) {
  BundleSimulationOptions options = TwoStrips(false);
  options.control_photos.clear();
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult result = AdjustBlock(simulation.block);
  EXPECT_FALSE(result.converged);
  for (std::size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(result.photos[i].state, PhotoState::kNoDatum);
    EXPECT_EQ(result.photos[i].pose.position_m, simulation.block.photos[i].approximate.position_m);
  }
  EXPECT_TRUE(Has(result.findings, Reason::kBlockWithoutDatum));
}

TEST(BlockDegenerate, ControlOnOneLineGivesNoDatum) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(false));
  int number = 0;
  for (BlockPoint& point : simulation.block.points)
    // Two points of control are always on one line.
    if (point.control && ++number > 2) point.control.reset();
  const BlockResult result = AdjustBlock(simulation.block);
  for (const AdjustedPhoto& photo : result.photos) EXPECT_EQ(photo.state, PhotoState::kNoDatum);
}

TEST(BlockDegenerate, APhotoThatNobodySharesAnythingWithIsNamed) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(false));
  Thin(&simulation, [](const ImageObservation& o) { return o.photo != 6; });
  const BlockResult result = AdjustBlock(simulation.block);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(result.photos[i].state, i == 6 ? PhotoState::kUndetermined : PhotoState::kAdjusted);
  EXPECT_EQ(SaidOf(result, Reason::kPartWithoutDatum), "s1_2");
  EXPECT_EQ(SaidOf(result, Reason::kPhotosUndetermined), "s1_2");
}

TEST(BlockDegenerate, APhotoOnTwoTiesIsUndeterminedAndTheOthersAreNot) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(false));
  int kept = 0;
  std::vector<int> rays(simulation.block.points.size(), 0);
  for (const ImageObservation& o : simulation.block.observations) ++rays[o.point];
  Thin(&simulation, [&](const ImageObservation& o) {
    return o.photo != 7 || (rays[o.point] >= 3 && kept++ < 2);
  });
  const BlockResult result = AdjustBlock(simulation.block);
  for (std::size_t i = 0; i < 8; ++i)
    EXPECT_EQ(result.photos[i].state, i == 7 ? PhotoState::kUndetermined : PhotoState::kAdjusted);
  EXPECT_LT(JudgeBundle(simulation, result).height_gsd, 1.5);
}

TEST(BlockDegenerate, TiesOfPhotosFromOnePlaceSayNothing) {
  BundleSimulation simulation = SimulateBundle(TwoStrips(true));
  // Photo 1 a second time, as it stands.
  BlockToAdjust& block = simulation.block;
  block.photos.push_back(block.photos[1]);
  block.photos.back().name = "again";
  const std::size_t first_new = block.points.size();
  std::vector<ImageObservation> more;
  for (const ImageObservation& o : block.observations) {
    if (o.photo != 1 || more.size() > 100) continue;
    ImageObservation once = o, twice = o;
    once.point = twice.point = block.points.size();
    twice.photo = 8;
    block.points.emplace_back();
    block.points.back().approximate_m = simulation.true_ground[o.point];
    more.push_back(once);
    more.push_back(twice);
  }
  block.observations.insert(block.observations.end(), more.begin(), more.end());
  const BlockResult result = AdjustBlock(block);
  for (std::size_t i = 0; i < block.observations.size(); ++i)
    if (block.observations[i].point >= first_new) {
      EXPECT_NE(result.observations[i].state, ObservationState::kUsed);
    }
  EXPECT_EQ(result.photos[8].state, PhotoState::kUndetermined);
  EXPECT_EQ(result.photos[1].state, PhotoState::kAdjusted);
}

TEST(BlockDegenerate, NothingAtAllIsNothing) {
  const BlockResult result = AdjustBlock(BlockToAdjust{});
  EXPECT_FALSE(result.converged);
  EXPECT_TRUE(result.photos.empty());
}

TEST(BlockDegenerate, BrokenPromisesThrow) {
  const BundleSimulation simulation = SimulateBundle(TwoStrips(true));
  BlockToAdjust bad_index = simulation.block;
  bad_index.observations[0].photo = 99;
  EXPECT_THROW(AdjustBlock(bad_index), std::invalid_argument);
  BlockToAdjust bad_covariance = simulation.block;
  bad_covariance.observations[0].covariance_px2.setZero();
  EXPECT_THROW(AdjustBlock(bad_covariance), std::invalid_argument);
  BlockOptions bad_option;
  bad_option.significance = 2;
  EXPECT_THROW(AdjustBlock(simulation.block, bad_option), std::invalid_argument);
}

// As where the image is so sharp, and the ground so vague, that nothing checks the image: the
// control speaks for both, and what goes is gone.
TEST(BlockDegenerate, ASightingWithoutRedundancyGoesOnceWhereItsControlIsWrong) {
  const BundleSimulation simulation = SimulateBundle(TwoStrips(false));
  std::vector<int> rays(simulation.block.points.size(), 0);
  for (const ImageObservation& o : simulation.block.observations) ++rays[o.point];
  // Not of the first observation.
  std::size_t alone = rays.size();
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (simulation.block.points[i].control && rays[i] == 1 &&
        i != simulation.block.observations[0].point)
      alone = i;
  ASSERT_LT(alone, rays.size());
  const BlockOptions options;
  BlockSystem system(simulation.block, options);
  BlockJudgement judgement(&system);
  judgement.Screen();
  BlockTests tests;
  tests.of_row.resize(system.rows.size());
  tests.of_control.resize(system.points.size());
  tests.of_control[alone] = {.t = 1000, .dof = 3};
  EXPECT_EQ(judgement.Apply(tests, 1).All(), 1);
  for (std::size_t i = 0; i < simulation.block.observations.size(); ++i)
    EXPECT_EQ(judgement.states()[i] == ObservationState::kRejected,
              simulation.block.observations[i].point == alone)
        << i;
  EXPECT_EQ(judgement.Apply(tests, 1).All(), 0) << "or the adjustment never ends";
}

}  // namespace
}  // namespace orient::block
