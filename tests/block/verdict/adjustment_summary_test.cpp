#include "block/verdict/adjustment_summary.h"

#include <gtest/gtest.h>

namespace orient::block {
namespace {

// Two photos; the points are two ties, a control patch, a check patch and a rejected one.
AdjustedBlock Adjusted() {
  AdjustedBlock adjusted;
  adjusted.block.photos.resize(2);
  adjusted.block.photos[0].name = "4711";
  adjusted.block.photos[1].name = "4712";
  adjusted.photo_of = {0, 1};
  adjusted.block.points.resize(5);
  adjusted.result.points.resize(5);
  adjusted.result.photos.resize(2);
  for (AdjustedPhoto& photo : adjusted.result.photos) photo.state = PhotoState::kAdjusted;
  adjusted.ties = 2;
  for (std::size_t i = 0; i < 5; ++i) {
    adjusted.block.points[i].id = static_cast<std::int64_t>(10 * i);
    adjusted.result.points[i].adjusted = true;
    if (i < 2) continue;
    adjusted.block.points[i].control.emplace();
    adjusted.block.points[i].control->ground_m = {1, 2, static_cast<double>(i)};
  }
  adjusted.block.points[3].held_out = true;
  adjusted.result.points[4].control_rejected = true;
  for (const std::size_t point : {1, 0, 2, 3, 4}) {
    adjusted.block.observations.push_back(
        {point % 2, point, {static_cast<double>(point), 5}, Eigen::Matrix2d::Identity()});
    ObservationResult seen;
    seen.state = ObservationState::kUsed;
    seen.w = static_cast<double>(point);
    adjusted.result.observations.push_back(seen);
  }
  return adjusted;
}

TEST(AdjustmentSummary, TiesComeFirstAndControlIsApart) {
  const AdjustmentResult summary = SummaryOf(Adjusted(), {});
  ASSERT_EQ(summary.ties.size(), 2u);
  ASSERT_EQ(summary.control.size(), 3u);
  EXPECT_EQ(summary.ties[1].id, 10);
  EXPECT_FALSE(summary.ties[1].control);
  EXPECT_EQ(summary.control[0].id, 20);
  EXPECT_EQ(summary.control[0].control->given_m, Eigen::Vector3d(1, 2, 2));
}

TEST(AdjustmentSummary, ControlIsUsedRejectedOrHeldOutAsCheck) {
  AdjustedBlock adjusted = Adjusted();
  const auto state = [&](std::size_t i) {
    return SummaryOf(adjusted, {}).control[i].control->state;
  };
  EXPECT_EQ(state(0), "used");
  EXPECT_EQ(state(1), "check");
  EXPECT_EQ(state(2), "rejected");
  adjusted.result.points[3].control_rejected = true;
  EXPECT_EQ(state(1), "check") << "it never was control";
}

TEST(AdjustmentSummary, EveryPointHasItsOwnSightings) {
  const AdjustmentResult summary = SummaryOf(Adjusted(), {});
  ASSERT_EQ(summary.ties[1].seen.size(), 1u);
  EXPECT_EQ(summary.ties[1].seen[0].photo, "4712");
  EXPECT_EQ(summary.ties[1].seen[0].pixel.x(), 1);
  EXPECT_EQ(summary.ties[1].seen[0].w, 1);
  EXPECT_EQ(summary.ties[1].seen[0].state, "used");
  ASSERT_EQ(summary.ties[0].seen.size(), 1u);
  EXPECT_EQ(summary.ties[0].seen[0].photo, "4711");
}

TEST(AdjustmentSummary, APointThatWasNotAdjustedHasNoGround) {
  AdjustedBlock adjusted = Adjusted();
  adjusted.result.points[0].adjusted = false;
  adjusted.result.points[1].covariance_m2 = Eigen::Vector3d(4, 9, -1e-9).asDiagonal();
  const AdjustmentResult summary = SummaryOf(adjusted, {});
  EXPECT_FALSE(summary.ties[0].ground_m || summary.ties[0].sigma_m);
  ASSERT_TRUE(summary.ties[1].sigma_m);
  EXPECT_EQ(*summary.ties[1].sigma_m, Eigen::Vector3d(2, 3, 0)) << "rounding is no NaN";
}

TEST(AdjustmentSummary, PoseObservationsAreThoseOfPhotosThatHadSomeAndWereAdjusted) {
  AdjustedBlock adjusted = Adjusted();
  EXPECT_TRUE(SummaryOf(adjusted, {}).approximations.empty());
  for (BlockPhoto& photo : adjusted.block.photos) {
    photo.prior.emplace();
    photo.gnss.emplace();
  }
  adjusted.result.photos[0].prior_rejected = true;
  adjusted.result.photos[1].gnss_rejected = true;
  AdjustmentResult summary = SummaryOf(adjusted, {});
  ASSERT_EQ(summary.approximations.size(), 2u);
  ASSERT_EQ(summary.gnss.size(), 2u);
  EXPECT_EQ(summary.approximations[0].state, "rejected");
  EXPECT_EQ(summary.approximations[1].state, "used");
  EXPECT_EQ(summary.gnss[0].state, "used");
  EXPECT_EQ(summary.gnss[1].state, "rejected");
  adjusted.result.photos[0].state = PhotoState::kUndetermined;
  adjusted.block.photos[1].gnss.reset();
  summary = SummaryOf(adjusted, {});
  ASSERT_EQ(summary.approximations.size(), 1u);
  EXPECT_EQ(summary.approximations[0].photo, "4712");
  EXPECT_TRUE(summary.gnss.empty());
}

TEST(AdjustmentSummary, PartsAndChecksHaveNamesAndFindingsStand) {
  AdjustedBlock adjusted = Adjusted();
  BlockPart part;
  part.photos = {1, 0};
  part.control_points = 1;
  const Finding of_part{.reason = Reason::kStated, .where = "hangs on little"};
  part.finding = of_part;
  adjusted.result.parts = {part};
  CheckPatch check;
  check.point = 3;
  check.rays = 1;
  adjusted.result.checks = {check};
  adjusted.checks_rejected_alone = 7;
  const Finding of_all_stages{.reason = Reason::kStated, .where = "of all stages"};
  const AdjustmentResult summary = SummaryOf(adjusted, {of_all_stages});
  ASSERT_EQ(summary.parts.size(), 1u);
  EXPECT_EQ(summary.parts[0].photos, (std::vector<std::string>{"4712", "4711"}));
  EXPECT_EQ(summary.parts[0].finding, of_part);
  EXPECT_FALSE(summary.parts[0].by_control);
  ASSERT_EQ(summary.checks.size(), 1u);
  EXPECT_EQ(summary.checks[0].id, 30) << "the patch's number, not its place";
  EXPECT_EQ(summary.checks_rejected_alone, 7);
  EXPECT_EQ(summary.findings, Findings{of_all_stages});
}

}  // namespace
}  // namespace orient::block
