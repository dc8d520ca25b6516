#include "block/bundle/sub_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "block/bundle/adjustment.h"
#include "tests/block/bundle/bundle_verdict.h"
#include "tools/bench/bundle_simulation.h"

namespace orient::block {
namespace {

// Six strips of 20 photos, control under every seventh.
BundleSimulationOptions LongBlock() {
  BundleSimulationOptions options;
  options.strips = 6;
  options.photos_in_strip = 20;
  options.ties_per_photo = 12;
  options.control_photos.clear();
  for (int i = 0; i < 120; i += 7) options.control_photos.push_back(i);
  return options;
}

BlockOptions AtMost(std::size_t photos) {
  BlockOptions options;
  options.most_photos = photos;
  return options;
}

TEST(SubBlocks, EveryPhotoIsInOneCoreWithAllThatShowsItsPoints) {
  const BlockToAdjust block = SimulateBundle(LongBlock()).block;
  const std::vector<SubBlock> subs = DivideBlock(block, 90);
  EXPECT_GT(subs.size(), 1u);
  std::vector<int> cores(block.photos.size(), 0);
  for (const SubBlock& sub : subs) {
    EXPECT_LE(sub.photos.size(), 90u);
    EXPECT_TRUE(std::is_sorted(sub.photos.begin(), sub.photos.end()));
    for (const std::size_t photo : sub.core) ++cores[photo];
    std::vector<bool> shown(block.points.size(), false);
    for (const ImageObservation& o : block.observations)
      if (sub.IsInCore(o.photo)) shown[o.point] = true;
    for (const ImageObservation& o : block.observations) {
      if (!shown[o.point]) continue;
      EXPECT_NE(sub.IsInCore(o.photo),
                std::binary_search(sub.beside.begin(), sub.beside.end(), o.photo));
      EXPECT_TRUE(std::binary_search(sub.photos.begin(), sub.photos.end(), o.photo));
    }
  }
  EXPECT_EQ(std::count(cores.begin(), cores.end(), 1), std::ssize(cores));
}

TEST(SubBlocks, PhotosThatAllShowTheSamePointsAreNotDividedForEver) {
  BundleSimulationOptions options;
  options.forward_overlap = 0.95;
  options.side_overlap = 0.9;
  const std::vector<SubBlock> subs = DivideBlock(SimulateBundle(options).block, 4);
  EXPECT_EQ(subs.size(), 15u);
}

TEST(SubBlocks, ABlockThatIsNotTooLargeIsAdjustedAsAWhole) {
  const BundleSimulation simulation = SimulateBundle({});
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult result = AdjustWholeOrInSubBlocks(simulation.block, AtMost(15));
  EXPECT_FALSE(result.sub_blocks);
  for (std::size_t i = 0; i < whole.photos.size(); ++i)
    EXPECT_EQ(result.photos[i].pose.AsVector(), whole.photos[i].pose.AsVector());
}

// As accurate as the whole, and as precise as stated; what is tested is judged alike.
TEST(SubBlocks, JoinedTheyAreHardlyWorseThanTheWhole) {
  BundleSimulationOptions options = LongBlock();
  options.gross_ties = options.gross_control = 0.01;
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(90));
  ASSERT_TRUE(joined.sub_blocks);
  EXPECT_GT(joined.sub_blocks->count, 1);
  EXPECT_GT(joined.sub_blocks->compared, 10);
  EXPECT_LT(joined.sub_blocks->differences, 0.5);
  EXPECT_TRUE(joined.converged);
  EXPECT_NEAR(joined.sigma0, whole.sigma0, 0.02);
  EXPECT_NEAR(joined.redundancy, whole.redundancy, 0.05 * whole.redundancy);
  ASSERT_EQ(joined.parts.size(), 1u);
  EXPECT_TRUE(joined.parts[0].has_datum && joined.parts[0].by_control);
  EXPECT_NEAR(joined.parts[0].control_points, whole.parts[0].control_points, 3);
  const BundleVerdict of_whole = JudgeBundle(simulation, whole),
                      of_joined = JudgeBundle(simulation, joined);
  EXPECT_LT(of_joined.horizontal_gsd, 1.05 * of_whole.horizontal_gsd);
  EXPECT_LT(of_joined.height_gsd, 1.05 * of_whole.height_gsd);
  EXPECT_NEAR(of_joined.PoseChi(), of_whole.PoseChi(), 0.1);
  double worst = 0;
  for (std::size_t i = 0; i < whole.photos.size(); ++i) {
    ASSERT_EQ(joined.photos[i].state, PhotoState::kAdjusted);
    const Vector6d ratio =
        joined.photos[i].covariance.diagonal().cwiseQuotient(whole.photos[i].covariance.diagonal());
    worst = std::max(worst, std::sqrt(ratio.maxCoeff()));
  }
  EXPECT_LT(worst, 1.1);
  int alike = 0;
  for (std::size_t i = 0; i < whole.observations.size(); ++i)
    alike += joined.observations[i].state == whole.observations[i].state ? 1 : 0;
  EXPECT_GT(alike, 0.995 * static_cast<double>(whole.observations.size()));
}

TEST(SubBlocks, ChecksAreOfTheSamePointsAsTheWholes) {
  BundleSimulation simulation = SimulateBundle(LongBlock());
  for (std::size_t i = 0; i < simulation.block.points.size(); ++i)
    if (simulation.block.points[i].control && i % 5 == 0)
      simulation.block.points[i].held_out = true;
  const BlockResult whole = AdjustBlock(simulation.block);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(90));
  ASSERT_EQ(joined.checks.size(), whole.checks.size());
  ASSERT_GT(whole.checks.size(), 10u);
  for (std::size_t i = 0; i < whole.checks.size(); ++i) {
    EXPECT_EQ(joined.checks[i].point, whole.checks[i].point);
    EXPECT_EQ(joined.checks[i].observations, whole.checks[i].observations);
    EXPECT_LT(
        (joined.checks[i].image_residuals_px[0] - whole.checks[i].image_residuals_px[0]).norm(),
        0.5);
  }
}

// Control in one corner and nothing else: the sub-blocks without it have no datum, and say so.
TEST(SubBlocks, ASubBlockWithoutControlIsNotAdjusted) {
  BundleSimulationOptions options = LongBlock();
  options.prior = false;
  options.control_photos = {0, 1, 2, 20, 21, 22};
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, AtMost(90));
  EXPECT_EQ(joined.photos.front().state, PhotoState::kAdjusted);
  EXPECT_EQ(joined.photos.back().state, PhotoState::kNoDatum);
  ASSERT_EQ(joined.parts.size(), 2u);
  EXPECT_TRUE(joined.parts[0].has_datum);
  EXPECT_FALSE(joined.parts[1].has_datum);
  EXPECT_EQ(joined.parts[1].control_points, 0);
  EXPECT_EQ(joined.parts[1].finding->reason, Reason::kPartWithoutDatum);
  for (const AdjustedPhoto& photo : joined.photos)
    EXPECT_EQ(photo.state == PhotoState::kAdjusted,
              joined.parts[static_cast<std::size_t>(photo.part)].has_datum);
}

TEST(SubBlocks, ShiftsOfStripsCutByABorderAreThoseOfTheLargerPart) {
  BundleSimulationOptions options = LongBlock();
  options.gnss_sigma_m = 0.05;
  options.gnss_shift_m = {0.3, -0.2, 0.5};
  const BundleSimulation simulation = SimulateBundle(options);
  BlockOptions how = AtMost(90);
  how.gnss = GnssModel::kShift;
  const BlockResult joined = AdjustWholeOrInSubBlocks(simulation.block, how);
  ASSERT_EQ(joined.strips.size(), 6u);
  for (const StripGnss& strip : joined.strips)
    EXPECT_LT((strip.shift_m - options.gnss_shift_m).cwiseQuotient(strip.shift_sigma_m).norm(), 5);
}

TEST(SubBlocks, BadInputIsRefused) {
  BundleSimulation simulation = SimulateBundle({});
  BlockOptions how = AtMost(10);
  how.self_calibration = true;
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, how), std::invalid_argument);
  simulation.block.observations[0].photo = 99;
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, AtMost(10)), std::invalid_argument);
  EXPECT_THROW(AdjustWholeOrInSubBlocks(simulation.block, AtMost(0)), std::invalid_argument);
}

}  // namespace
}  // namespace orient::block
