#include "block/bundle/adjustment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <random>

#include "tests/block/bundle/bundle_verdict.h"

namespace orient::block {
namespace {

// Of the ground sampling distance, RMS.
constexpr double kHorizontalGsd = 0.6, kHeightGsd = 0.9;

TEST(BlockAdjustment, CarriesControlUnderFourPhotosThroughTheWholeBlock) {
  for (unsigned seed = 1; seed <= 2; ++seed) {
    BundleSimulationOptions options;
    options.seed = seed;
    const BundleSimulation simulation = SimulateBundle(options);
    const BlockResult result = AdjustBlock(simulation.block);
    const BundleVerdict verdict = JudgeBundle(simulation, result);
    EXPECT_LT(verdict.worst_photo_horizontal, kHorizontalGsd);
    EXPECT_LT(verdict.worst_photo_height, kHeightGsd);
    EXPECT_NEAR(result.sigma0, 1, 0.05);
    EXPECT_TRUE(result.findings.empty()) << JoinedSentences(result.findings);
  }
}

TEST(BlockAdjustment, SaysHowPreciseItIs) {
  BundleVerdict all;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const BundleSimulation simulation = SimulateBundle(SmallBlock(seed));
    all.Add(JudgeBundle(simulation, AdjustBlock(simulation.block)));
  }
  EXPECT_GT(all.PoseChi(), 0.8);
  EXPECT_LT(all.PoseChi(), 1.25);
  EXPECT_GT(all.PointChi(), 0.8);
  EXPECT_LT(all.PointChi(), 1.25);
}

// Approximations and GNSS that are all far off, against a little control: it loses, and that is
// said although no observation of its group is left.
TEST(BlockAdjustment, ControlOfWhichNothingIsLeftIsToldOf) {
  BundleSimulationOptions options;
  options.seed = 1;
  options.ties_per_photo = 15;
  options.control_per_photo = 8;
  options.gnss_sigma_m = 0.05;
  BundleSimulation simulation = SimulateBundle(options);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const auto off = [&](double sigma_m) -> Eigen::Vector3d {
    const double x = normal(random), y = normal(random), z = normal(random);
    return sigma_m * Eigen::Vector3d(x, y, z);
  };
  for (BlockPhoto& photo : simulation.block.photos) {
    photo.approximate.position_m += off(60);
    photo.prior->pose = photo.approximate;
    photo.gnss->position_m += off(20);
  }
  BlockOptions how;
  how.gnss = GnssModel::kShift;
  const BlockResult result = AdjustBlock(simulation.block, how);
  EXPECT_TRUE(std::none_of(
      result.components.begin(), result.components.end(),
      [](const VarianceComponent& component) { return component.group == "control ground"; }));
  EXPECT_TRUE(std::any_of(
      result.findings.begin(), result.findings.end(),
      [](const Finding& finding) { return finding.reason == Reason::kControlWorseThanStated; }));
}

// Fifteen blocks, clean and with gross errors: as precise as they say, and hardly worse.
TEST(SlowBlockAdjustment, SaysHowPreciseItIsOfManyBlocks) {
  constexpr int kBlocks = 15;
  Eigen::Vector2d clean_rms = Eigen::Vector2d::Zero();
  for (const double gross : {0.0, 0.05}) {
    BundleVerdict all;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (unsigned seed = 1; seed <= kBlocks; ++seed) {
      BundleSimulationOptions options;
      options.seed = seed;
      options.gross_ties = options.gross_control = gross;
      const BundleSimulation simulation = SimulateBundle(options);
      const BundleVerdict verdict = JudgeBundle(simulation, AdjustBlock(simulation.block));
      EXPECT_LT(verdict.worst_photo_horizontal, kHorizontalGsd);
      sum += Eigen::Vector2d(verdict.horizontal_gsd, verdict.height_gsd).cwiseAbs2();
      all.Add(verdict);
    }
    const Eigen::Vector2d rms = (sum / kBlocks).cwiseSqrt();
    std::printf(
        "%.0f %% gross errors: check points %.3f GSD horizontally, %.3f in height; normalised "
        "errors of poses %.2f, of points %.2f; of %d gross errors %d can be found, %d are named, "
        "of the rest %d, %d good ones besides\n",
        100 * gross, rms.x(), rms.y(), all.PoseChi(), all.PointChi(), all.gross, all.findable,
        all.findable_named, all.gross_named - all.findable_named, all.wrongly_named);
    EXPECT_LT(rms.x(), kHorizontalGsd);
    EXPECT_LT(rms.y(), kHeightGsd);
    EXPECT_NEAR(all.PoseChi(), 1.0, 0.2);
    EXPECT_NEAR(all.PointChi(), 1.0, 0.2);
    EXPECT_GE(all.findable_named, 0.95 * all.findable);
    if (gross == 0) clean_rms = rms;
    EXPECT_LT(rms.x(), 1.1 * clean_rms.x());
    EXPECT_LT(rms.y(), 1.1 * clean_rms.y());
  }
}

TEST(BlockAdjustment, NamesGrossErrorsAndIsHardlyWorseForThem) {
  BundleSimulationOptions options;
  options.control_seen_by_all = true;
  const BundleSimulation clean = SimulateBundle(options);
  options.gross_ties = options.gross_control = 0.05;
  const BundleSimulation spoilt = SimulateBundle(options);
  const BlockResult result = AdjustBlock(spoilt.block);
  const BundleVerdict with = JudgeBundle(spoilt, result);
  const BundleVerdict without = JudgeBundle(clean, AdjustBlock(clean.block));
  EXPECT_GE(with.findable_named, 0.95 * with.findable) << "of " << with.findable;
  EXPECT_GT(with.findable, 150);
  EXPECT_LT(with.horizontal_gsd, 1.1 * without.horizontal_gsd);
  EXPECT_LT(with.height_gsd, 1.1 * without.height_gsd);
  EXPECT_NEAR(result.sigma0, 1, 0.05);
}

TEST(BlockAdjustment, TakesTheNoiseFromTheResidualsNotFromWhatIsStated) {
  BundleSimulationOptions options = SmallBlock();
  options.stated_px = 0.1;
  const BundleSimulation simulation = SimulateBundle(options);
  const BlockResult result = AdjustBlock(simulation.block);
  ASSERT_FALSE(result.components.empty());
  EXPECT_EQ(result.components[0].group, "tie image");
  EXPECT_TRUE(result.components[0].estimated);
  EXPECT_NEAR(result.components[0].sigma0_px, 0.3, 0.015);
  EXPECT_NEAR(result.components[0].factor, 9, 0.9);
  EXPECT_NEAR(result.sigma0, 2.9, 0.2);  // control and priors, rightly stated, are in it, too
  const BundleVerdict verdict = JudgeBundle(simulation, result);
  EXPECT_LT(verdict.PointChi(), 1.25);
  EXPECT_GT(verdict.PointChi(), 0.8);
}

TEST(BlockAdjustment, IsNoMorePreciseThanStatedWhereItIsToldSo) {
  BundleSimulationOptions options = SmallBlock();
  options.stated_px = 0.6;
  const BundleSimulation simulation = SimulateBundle(options);
  BlockOptions careful, stated;
  careful.least_precision_factor = 1;
  stated.variance_components = false;
  const BlockResult by_residuals = AdjustBlock(simulation.block);
  const BlockResult carefully = AdjustBlock(simulation.block, careful);
  const BlockResult as_stated = AdjustBlock(simulation.block, stated);
  EXPECT_NEAR(by_residuals.components[0].factor, 0.25, 0.03);
  // The same weights, hence the same poses; covariances as if nothing had been learnt.
  EXPECT_EQ(carefully.components[0].factor, by_residuals.components[0].factor);
  for (std::size_t i = 0; i < carefully.photos.size(); ++i) {
    EXPECT_EQ(carefully.photos[i].pose.position_m, by_residuals.photos[i].pose.position_m);
    EXPECT_NEAR(carefully.photos[i].covariance(2, 2) / as_stated.photos[i].covariance(2, 2), 1,
                0.1);
    EXPECT_GT(carefully.photos[i].covariance(2, 2), 1.5 * by_residuals.photos[i].covariance(2, 2));
  }
}

// Ceres calls a run that was cut off usable.
TEST(BlockAdjustment, SaysWhereItDidNotComeToRest) {
  BundleSimulationOptions simulated = SmallBlock();
  simulated.gross_ties = 0.05;
  const BundleSimulation simulation = SimulateBundle(simulated);
  EXPECT_TRUE(AdjustBlock(simulation.block).converged);
  BlockOptions few_rounds, few_iterations;
  few_rounds.max_rounds = 1;
  few_iterations.max_iterations = 1;
  few_iterations.max_rounds = 2;
  few_iterations.snooping = few_iterations.robust_start = false;
  for (const BlockOptions& options : {few_rounds, few_iterations}) {
    const BlockResult result = AdjustBlock(simulation.block, options);
    EXPECT_FALSE(result.converged);
    ASSERT_FALSE(result.findings.empty());
    EXPECT_EQ(result.findings[0].reason, Reason::kAdjustmentNotConverged);
  }
}

TEST(BlockAdjustment, HasNothingToDoWithHeldOutPatches) {
  BundleSimulationOptions options = SmallBlock();
  options.control_seen_by_all = true;
  BundleSimulation simulation = SimulateBundle(options);
  BlockToAdjust without = simulation.block;
  without.observations.clear();
  std::size_t held_out = 0;
  for (BlockPoint& point : simulation.block.points)
    point.held_out = point.control && ++held_out % 3 == 0;
  for (const ImageObservation& o : simulation.block.observations)
    if (!simulation.block.points[o.point].held_out) without.observations.push_back(o);
  const BlockResult with_checks = AdjustBlock(simulation.block);
  const BlockResult alone = AdjustBlock(without);
  ASSERT_EQ(with_checks.checks.size(), held_out / 3);
  for (std::size_t i = 0; i < alone.photos.size(); ++i)
    EXPECT_LT(PoseDifference(alone.photos[i].pose, with_checks.photos[i].pose).norm(), 1e-5);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  int count = 0;
  for (const CheckPatch& check : with_checks.checks) {
    for (const std::size_t i : check.observations)
      EXPECT_EQ(with_checks.observations[i].state, ObservationState::kHeldOut);
    for (const Eigen::Vector2d& residual : check.image_residuals_px) EXPECT_LT(residual.norm(), 4);
    if (!check.ground_residual_m) continue;
    squares += check.ground_residual_m->cwiseAbs2();
    ++count;
  }
  EXPECT_GT(count, 7);
  const Eigen::Vector3d rms = (squares / count).cwiseSqrt();
  EXPECT_LT(rms.head<2>().maxCoeff(), 0.5) << rms.transpose();
  EXPECT_LT(rms.z(), 1) << rms.transpose();
}

TEST(BlockAdjustment, GivesTheWholeCovarianceOfThePoses) {
  const BundleSimulation simulation = SimulateBundle(SmallBlock());
  const BlockResult result = AdjustBlock(simulation.block);
  ASSERT_EQ(result.covariance_photos.size(), 15u);
  ASSERT_EQ(result.pose_covariance.rows(), 90);
  for (std::size_t i = 0; i < 15; ++i) {
    const auto at = 6 * static_cast<Eigen::Index>(i);
    const Matrix6d block = result.pose_covariance.block<6, 6>(at, at);
    EXPECT_LT((block - result.photos[i].covariance).norm(), 1e-6 * block.norm());
  }
  // Neighbours err together.
  EXPECT_GT(result.pose_covariance(2, 8), 0);
}

TEST(SlowBlockAdjustment, KnowsWhatAFilmTransformsErrorsDo) {
  BundleVerdict all;
  for (unsigned seed = 1; seed <= 4; ++seed) {
    BundleSimulationOptions options = SmallBlock(seed);
    options.interior_sigma_mm = 0.01;
    const BundleSimulation simulation = SimulateBundle(options);
    all.Add(JudgeBundle(simulation, AdjustBlock(simulation.block)));
  }
  EXPECT_GT(all.PoseChi(), 0.75);
  EXPECT_LT(all.PoseChi(), 1.25);
  EXPECT_GT(all.PointChi(), 0.8);
  EXPECT_LT(all.PointChi(), 1.25);
}

// Errors that all patches of a source share hardly show in residuals: the poses stay what they are,
// their covariances hold what such errors do to them.
TEST(BlockAdjustment, PropagatesWhatControlErrsTogether) {
  BundleVerdict all, naive;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    BundleSimulationOptions simulated = SmallBlock(seed);
    simulated.ties_per_photo = 20;
    simulated.control_shared_everywhere = 0.5;
    simulated.control_shared_smoothly = 0.8;
    const BundleSimulation simulation = SimulateBundle(simulated);
    BlockOptions options;
    const BlockResult plain = AdjustBlock(simulation.block, options);
    options.control_shared_everywhere = 0.5;
    options.control_shared_smoothly = 0.8;
    const BlockResult wide = AdjustBlock(simulation.block, options);
    naive.Add(JudgeBundle(simulation, plain));
    all.Add(JudgeBundle(simulation, wide));
    ASSERT_EQ(wide.covariance_photos.size(), wide.photos.size());
    for (std::size_t i = 0; i < wide.photos.size(); ++i) {
      EXPECT_EQ(wide.photos[i].pose.AsVector(), plain.photos[i].pose.AsVector());
      const Matrix6d together = wide.pose_covariance.block<6, 6>(6 * static_cast<Eigen::Index>(i),
                                                                 6 * static_cast<Eigen::Index>(i));
      EXPECT_TRUE(together.isApprox(wide.photos[i].covariance, 1e-6));
    }
    EXPECT_GT(Eigen::LDLT<Eigen::MatrixXd>(wide.pose_covariance).vectorD().minCoeff(), 0);
  }
  EXPECT_GT(all.PointChi(), 0.8);
  EXPECT_LT(all.PointChi(), 1.25);
  EXPECT_GT(all.PoseChi(), 0.8);
  EXPECT_LT(all.PoseChi(), 1.25);
  EXPECT_GT(naive.PoseChi(), 1.3 * all.PoseChi());
  EXPECT_GT(naive.PointChi(), 1.2 * all.PointChi());
}

// The poses follow their source wherever it is; their covariances hold where it may be.
TEST(BlockAdjustment, PropagatesThatASourceMayBeDisplaced) {
  BundleVerdict all, naive;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    BundleSimulationOptions simulated = SmallBlock(seed);
    simulated.ties_per_photo = 20;
    simulated.source_sigma_m = 0.3;
    BundleSimulation simulation = SimulateBundle(simulated);
    const BlockResult wide = AdjustBlock(simulation.block);
    all.Add(JudgeBundle(simulation, wide));
    for (BlockPoint& point : simulation.block.points)
      if (point.control) point.control->source_sigma_m = 0;
    const BlockResult plain = AdjustBlock(simulation.block);
    naive.Add(JudgeBundle(simulation, plain));
    for (std::size_t i = 0; i < wide.photos.size(); ++i)
      EXPECT_EQ(wide.photos[i].pose.AsVector(), plain.photos[i].pose.AsVector());
  }
  EXPECT_GT(all.PoseChi(), 0.7);
  EXPECT_LT(all.PoseChi(), 1.25);
  EXPECT_GT(naive.PoseChi(), 1.5);
}

TEST(SlowBlockAdjustment, KnowsThatPatchesOfOneSourceShareHeightErrors) {
  BundleVerdict all, naive;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    BundleSimulationOptions options = SmallBlock(seed);
    options.height_sigma_m = 1;
    BundleSimulation simulation = SimulateBundle(options);
    all.Add(JudgeBundle(simulation, AdjustBlock(simulation.block)));
    for (BlockPoint& point : simulation.block.points)
      if (point.control) point.control->height_sigma_m = 0;
    naive.Add(JudgeBundle(simulation, AdjustBlock(simulation.block)));
  }
  EXPECT_GT(all.PoseChi(), 0.75);
  EXPECT_LT(all.PoseChi(), 1.25);
  EXPECT_LT(all.PointChi(), 1.25);
  EXPECT_GT(naive.PoseChi(), 1.5);
}

}  // namespace
}  // namespace orient::block
