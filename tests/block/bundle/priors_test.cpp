// GNSS positions and approximations as observations of a block.
#include <gtest/gtest.h>

#include <cstdio>

#include "block/bundle/adjustment.h"
#include "tests/block/bundle/bundle_verdict.h"

namespace orient::block {
namespace {

TEST(BlockAdjustment, FindsTheShiftOfAStripsGnss) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.gnss_shift_m = {1.5, -0.7, 0.4};
  const BundleSimulation simulation = SimulateBundle(options);
  BlockOptions with_shift;
  with_shift.gnss = GnssModel::kShift;
  const BlockResult result = AdjustBlock(simulation.block, with_shift);
  ASSERT_EQ(result.strips.size(), 3u);
  for (const StripGnss& strip : result.strips) {
    const Eigen::Vector3d off = strip.shift_m - options.gnss_shift_m;
    for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(off[i]), 4 * strip.shift_sigma_m[i]);
    EXPECT_LT(strip.shift_sigma_m.maxCoeff(), 0.4);
  }
  for (const AdjustedPhoto& photo : result.photos)
    EXPECT_LT(photo.gnss_residual_m.value().norm(), 0.3);
}

TEST(BlockAdjustment, FindsTheDriftOfAStripsGnss) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  BundleSimulation simulation = SimulateBundle(options);
  const Eigen::Vector3d drift(0.4, -0.2, 0.6);
  for (BlockPhoto& photo : simulation.block.photos)
    photo.gnss->position_m += drift * photo.gnss->along_strip;
  BlockOptions drifting;
  drifting.gnss = GnssModel::kShiftAndDrift;
  const BlockResult result = AdjustBlock(simulation.block, drifting);
  ASSERT_EQ(result.strips.size(), 3u);
  for (const StripGnss& strip : result.strips) {
    for (int i = 0; i < 3; ++i)
      EXPECT_LT(std::abs((*strip.drift_m)[i] - drift[i]), 4 * (*strip.drift_sigma_m)[i]);
    EXPECT_LT(strip.drift_sigma_m->maxCoeff(), 0.3);
  }
}

// Tight ones, that would draw their photos along were they believed.
TEST(BlockAdjustment, NamesWrongGnssAndWrongApproximations) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.position_sigma_m = 0.5;
  options.attitude_sigma_rad = 0.001;
  BundleSimulation simulation = SimulateBundle(options);
  BlockOptions with_shift;
  with_shift.gnss = GnssModel::kShift;
  BlockToAdjust without = simulation.block;
  without.photos[3].gnss.reset();
  without.photos[8].gnss.reset();
  without.photos[11].prior.reset();
  const BlockResult right = AdjustBlock(without, with_shift);
  simulation.block.photos[3].gnss->position_m.x() += 30;
  simulation.block.photos[8].gnss->position_m.z() -= 1;
  simulation.block.photos[11].prior->pose.opk_rad[2] += 0.5;
  const BlockResult result = AdjustBlock(simulation.block, with_shift);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_EQ(result.photos[i].gnss_rejected, i == 3 || i == 8) << i;
    EXPECT_EQ(result.photos[i].prior_rejected, i == 11) << i;
    EXPECT_LT((result.photos[i].pose.position_m - right.photos[i].pose.position_m).norm(), 0.02);
  }
  EXPECT_NEAR(result.photos[3].gnss_residual_m->x(), 30, 0.5);
  ASSERT_EQ(result.findings.size(), 2u);
  EXPECT_EQ(result.findings[0],
            (Finding{.reason = Reason::kGnssRejected, .value = 2, .where = "s0_3 and s1_3"}));
  EXPECT_EQ(result.findings[1],
            (Finding{.reason = Reason::kApproximationsRejected, .value = 1, .where = "s2_1"}));
}

// Without a shift that a strip has alone, a wrong position draws the others of all strips.
TEST(BlockAdjustment, NamesTheOneWrongPositionAmongThoseThatShareNoShift) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  BundleSimulation simulation = SimulateBundle(options);
  simulation.block.photos[7].gnss->position_m.y() += 3;
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  const BlockResult result = AdjustBlock(simulation.block, plain);
  for (std::size_t i = 0; i < 15; ++i) EXPECT_EQ(result.photos[i].gnss_rejected, i == 7) << i;
}

// The larger error is a few of thousands of observations, but nearly all of the positions' sum of
// squares: by a variance component taken before it is out the smaller one would pass.
TEST(BlockAdjustment, NamesTwoWrongPositionsOfAStripWithShifts) {
  for (const GnssModel model : {GnssModel::kShift, GnssModel::kShiftAndDrift}) {
    BundleSimulationOptions options = SmallBlock();
    options.gnss_sigma_m = 0.05;
    options.photos_in_strip = 7;
    options.control_photos = {0, 6, 14, 20};
    BundleSimulation simulation = SimulateBundle(options);
    simulation.block.photos[9].gnss->position_m.x() += 2;
    simulation.block.photos[11].gnss->position_m.y() += 60;
    BlockOptions with_shift;
    with_shift.gnss = model;
    const BlockResult result = AdjustBlock(simulation.block, with_shift);
    for (std::size_t i = 0; i < 21; ++i)
      EXPECT_EQ(result.photos[i].gnss_rejected, i == 9 || i == 11) << i;
    EXPECT_FALSE(Has(result.findings, Reason::kGnssWorseThanStated));
  }
}

// Positions that differ from the truth by 5 cm and by this.
BundleSimulation WithShiftedGnss(const Eigen::Vector3d& shift_m) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.gnss_shift_m = shift_m;
  return SimulateBundle(options);
}

Findings FindingsWithPlainGnss(const BundleSimulation& simulation) {
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  return AdjustBlock(simulation.block, plain).findings;
}

// "dx 3.00 dy 0.00 dz 0.00 m"
void ExpectShift(const std::string& text, const Eigen::Vector3d& shift_m) {
  Eigen::Vector3d said = Eigen::Vector3d::Constant(1e9);
  ASSERT_EQ(std::sscanf(text.c_str(), "dx %lf dy %lf dz %lf m", &said.x(), &said.y(), &said.z()),
            3);
  EXPECT_LT((said - shift_m).norm(), 0.3) << text;
}

TEST(BlockAdjustment, SaysThatAllGnssLiesInAnotherDatumThanControlAndByHowMuch) {
  for (const Eigen::Vector3d& shift_m : {Eigen::Vector3d(0, 0, 40), Eigen::Vector3d(3, -1, 0)}) {
    const Findings findings = FindingsWithPlainGnss(WithShiftedGnss(shift_m));
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].reason, Reason::kGnssPerhapsOfAnotherDatum);
    EXPECT_EQ(findings[0].value, 15);
    EXPECT_EQ(findings[0].limit, 15);
    ExpectShift(findings[0].where, shift_m);
  }
  EXPECT_EQ(
      Sentence({.reason = Reason::kGnssPerhapsOfAnotherDatum,
                .value = 14,
                .limit = 15,
                .where = "dx 0.02 dy -0.01 dz 40.00 m"}),
      "14 of 15 GNSS positions differ from control by the same shift, dx 0.02 dy -0.01 dz 40.00 m: "
      "another datum, a geoid, the antenna's offset, or a wrong principal distance? The block "
      "follows control.");
}

int RejectedControl(const BlockToAdjust& block, const BlockResult& result) {
  int rejected = 0;
  for (std::size_t i = 0; i < block.observations.size(); ++i)
    if (block.points[block.observations[i].point].control &&
        result.observations[i].state == ObservationState::kRejected)
      ++rejected;
  return rejected;
}

// Few patches used to give way to many precise positions without a word, and more of them where one
// position was a gross error besides.
TEST(BlockAdjustment, ControlHoldsAgainstAShiftThatAllGnssShares) {
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  for (const int control_per_photo : {4, 12})
    for (const double shift_m : {1.0, 5.0, 20.0, 40.0}) {
      BundleSimulationOptions options = SmallBlock();
      options.control_per_photo = control_per_photo;
      options.gnss_sigma_m = 0.05;
      options.gnss_shift_m = {shift_m, 0, 0};
      BundleSimulation simulation = SimulateBundle(options);
      simulation.block.photos[7].gnss->position_m.y() += 60;
      const BlockResult result = AdjustBlock(simulation.block, plain);
      EXPECT_LE(RejectedControl(simulation.block, result), 1) << shift_m;
      Eigen::Vector3d off_m = Eigen::Vector3d::Zero();
      for (std::size_t i = 0; i < 15; ++i) {
        EXPECT_EQ(result.photos[i].gnss_rejected, i == 7) << i;
        off_m += (result.photos[i].pose.position_m - simulation.true_poses[i].position_m) / 15;
      }
      EXPECT_LT(off_m.norm(), 0.3) << shift_m;
      ASSERT_TRUE(Has(result.findings, Reason::kGnssPerhapsOfAnotherDatum));
      EXPECT_EQ(result.findings.back().value, 14);
      ExpectShift(result.findings.back().where, {shift_m, 0, 0});
      ASSERT_EQ(result.strips.size(), 1u);
      EXPECT_LT((result.strips[0].shift_m - options.gnss_shift_m)
                    .cwiseQuotient(result.strips[0].shift_sigma_m)
                    .norm(),
                4);
    }
}

// What control shares lies between it and GNSS, too.
TEST(BlockAdjustment, ErrorsThatControlSharesAreNoShiftOfGnss) {
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  plain.control_shared_everywhere = 0.5;
  plain.control_shared_smoothly = 0.8;
  plain.height_correlation_m = 500;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    BundleSimulationOptions options = SmallBlock();
    options.gnss_sigma_m = 0.05;
    options.ties_per_photo = 30;
    options.control_shared_everywhere = 0.5;
    options.control_shared_smoothly = 0.8;
    options.seed = seed;
    const BlockResult result = AdjustBlock(SimulateBundle(options).block, plain);
    EXPECT_TRUE(result.converged);
    EXPECT_FALSE(Has(result.findings, Reason::kGnssPerhapsOfAnotherDatum)) << seed;
    EXPECT_TRUE(result.strips.empty());
  }
}

TEST(BlockAdjustment, PhotosThatTakeNoPartDoNotOutvoteAShiftOfGnss) {
  BundleSimulation simulation = WithShiftedGnss({5, 0, 0});
  for (int i = 0; i < 20; ++i) {  // show no point
    BlockPhoto alone = simulation.block.photos[0];
    alone.name = "alone" + std::to_string(i);
    simulation.block.photos.push_back(alone);
  }
  EXPECT_TRUE(Has(FindingsWithPlainGnss(simulation), Reason::kGnssPerhapsOfAnotherDatum));
}

void ExpectPlainGnssIsFollowed(const BundleSimulation& simulation) {
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  const BlockResult result = AdjustBlock(simulation.block, plain);
  EXPECT_FALSE(Has(result.findings, Reason::kGnssPerhapsOfAnotherDatum));
  for (std::size_t i = 0; i < 15; ++i)
    EXPECT_LT((result.photos[i].pose.position_m - simulation.true_poses[i].position_m).norm(), 1);
}

// Either of two may be the wrong one.
TEST(BlockAdjustment, OneControlPointThatIsWrongDoesNotMoveAllGnss) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.control_photos = {0};
  options.control_per_photo = 1;
  options.control_seen_by_all = true;
  BundleSimulation simulation = SimulateBundle(options);
  for (BlockPoint& point : simulation.block.points)
    if (point.control) point.control->ground_m.x() += 10;
  ExpectPlainGnssIsFollowed(simulation);
}

// The approximations' common error is no witness against GNSS where control says too little.
TEST(BlockAdjustment, ApproximationsAreNoWitnessesAgainstGnss) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.control_photos = {0};
  options.control_per_photo = 2;
  BundleSimulation simulation = SimulateBundle(options);
  for (BlockPhoto& photo : simulation.block.photos) {
    photo.approximate.position_m.x() += 12;
    photo.prior->pose.position_m.x() += 12;
  }
  ExpectPlainGnssIsFollowed(simulation);
}

TEST(BlockAdjustment, SaysThatControlIsWorseThanStated) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  options.control_ground_m = 2;
  BundleSimulation simulation = SimulateBundle(options);
  for (BlockPoint& point : simulation.block.points)
    if (point.control) point.control->covariance_m2 /= 400;
  BlockOptions plain;
  plain.gnss = GnssModel::kPlain;
  EXPECT_TRUE(Has(AdjustBlock(simulation.block, plain).findings, Reason::kControlWorseThanStated));
}

TEST(BlockAdjustment, CountsOnlyPositionsThatShareTheShift) {
  BundleSimulation simulation = WithShiftedGnss({30, -15, 40});
  simulation.block.photos[3].gnss->position_m.x() += 60;
  simulation.block.photos[8].gnss->position_m.z() -= 90;
  const Findings findings = FindingsWithPlainGnss(simulation);
  ASSERT_TRUE(Has(findings, Reason::kGnssPerhapsOfAnotherDatum));
  EXPECT_EQ(findings.back().value, 13);
  EXPECT_EQ(findings.back().limit, 15);
  ExpectShift(findings.back().where, {30, -15, 40});
}

TEST(BlockAdjustment, PositionsThatAreWorseThanStatedShareNoShift) {
  BundleSimulation simulation = WithShiftedGnss(Eigen::Vector3d::Zero());
  double angle = 0;
  for (BlockPhoto& photo : simulation.block.photos) {
    photo.gnss->position_m +=
        Eigen::Vector3d(std::sin(angle), std::cos(angle), std::sin(5 * angle));
    angle += 2;
  }
  const Findings findings = FindingsWithPlainGnss(simulation);
  EXPECT_TRUE(Has(findings, Reason::kGnssWorseThanStated));
  EXPECT_FALSE(Has(findings, Reason::kGnssPerhapsOfAnotherDatum));
  EXPECT_TRUE(FindingsWithPlainGnss(WithShiftedGnss(Eigen::Vector3d::Zero())).empty());
}

// The shift of the strip fits either.
TEST(BlockAdjustment, BelievesNeitherOfTwoPositionsThatDisagree) {
  BundleSimulationOptions options = SmallBlock();
  options.gnss_sigma_m = 0.05;
  BundleSimulation simulation = SimulateBundle(options);
  for (const std::size_t i : {0, 3, 4}) simulation.block.photos[i].gnss.reset();
  simulation.block.photos[2].gnss->position_m.y() += 20;
  BlockOptions with_shift;
  with_shift.gnss = GnssModel::kShift;
  const BlockResult result = AdjustBlock(simulation.block, with_shift);
  for (std::size_t i = 0; i < 15; ++i)
    EXPECT_EQ(result.photos[i].gnss_rejected, i == 1 || i == 2) << i;
}

// What nobody states has no part in the variance component of what is stated.
TEST(BlockAdjustment, BelievesPositionsWithoutAttitudesNoMoreThanTheyAreWorth) {
  BundleSimulation simulation = SimulateBundle(SmallBlock());
  for (BlockPhoto& photo : simulation.block.photos) {
    photo.prior->covariance.topRows<3>() /= 100;
    photo.prior->covariance.bottomRightCorner<3, 3>() =
        Eigen::Matrix3d::Identity() * kOpenAttitude_rad * kOpenAttitude_rad;
  }
  const BlockResult result = AdjustBlock(simulation.block);
  const auto component = std::find_if(result.components.begin(), result.components.end(),
                                      [](const auto& of) { return of.group == "pose prior"; });
  ASSERT_NE(component, result.components.end());
  EXPECT_GT(component->factor, 40);
  EXPECT_NEAR(component->redundancy, 3 * 15, 5);
}

TEST(BlockAdjustment, BelievesApproximationsNoMoreThanTheyAreWorth) {
  const BundleSimulation simulation = SimulateBundle(SmallBlock());
  BlockToAdjust boasting = simulation.block, silent = simulation.block;
  for (BlockPhoto& photo : boasting.photos) photo.prior->covariance /= 100;
  for (BlockPhoto& photo : silent.photos) photo.prior.reset();
  const BlockResult result = AdjustBlock(boasting), without = AdjustBlock(silent);
  const auto component = std::find_if(result.components.begin(), result.components.end(),
                                      [](const auto& of) { return of.group == "pose prior"; });
  ASSERT_NE(component, result.components.end());
  EXPECT_GT(component->factor, 40);
  for (std::size_t i = 0; i < 15; ++i) {
    EXPECT_FALSE(result.photos[i].prior_rejected);
    const Vector6d moved = PoseDifference(result.photos[i].pose, without.photos[i].pose);
    EXPECT_LT(moved.dot(without.photos[i].covariance.ldlt().solve(moved)), 3);
  }
}

}  // namespace
}  // namespace orient::block
