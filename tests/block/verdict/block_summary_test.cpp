#include "block/verdict/block_summary.h"

#include <gtest/gtest.h>

#include "block/bundle/bundle_result.h"
#include "tests/support/example_adjustment.h"

namespace orient::block {
namespace {

TEST(BlockSummary, CountsWhatTookPart) {
  std::vector<BlockPhotoFile> photos(5);
  photos[1].by_neighbours = photos[4].by_neighbours = true;
  const BlockSummary summary = Summarize(ExampleAdjustment(), photos);
  EXPECT_EQ(summary.photos, 3) << "those of all parts, and not all that there are";
  EXPECT_EQ(summary.by_neighbours, 2);
  EXPECT_EQ(summary.ties, 2) << "control is none";
  EXPECT_EQ(summary.sightings, 4);
  EXPECT_EQ(summary.checks, 1);
}

TEST(BlockSummary, OnlyGrossErrorsAreRejected) {
  AdjustmentResult adjusted = ExampleAdjustment();
  EXPECT_EQ(Summarize(adjusted, {}).rejected, 1);
  adjusted.ties[0].seen[0].state = Name(ObservationState::kWeakAngle);
  adjusted.ties[0].seen[1].state = Name(ObservationState::kUnusable);
  EXPECT_EQ(Summarize(adjusted, {}).rejected, 1);
  adjusted.ties[0].seen[0].state = Name(ObservationState::kRejected);
  EXPECT_EQ(Summarize(adjusted, {}).rejected, 2);
  EXPECT_EQ(Summarize(adjusted, {}).sightings, 4);
}

TEST(BlockSummary, Sigma0IsThatOfTheTiesInTheImages) {
  AdjustmentResult adjusted = ExampleAdjustment();
  EXPECT_EQ(Summarize(adjusted, {}).tie_sigma0_px, 0.24);
  adjusted.components.insert(adjusted.components.begin(), {"control image", 2, 10, 0.7, true});
  EXPECT_EQ(Summarize(adjusted, {}).tie_sigma0_px, 0.24);
  adjusted.components.clear();
  EXPECT_EQ(Summarize(adjusted, {}).tie_sigma0_px, std::nullopt);
}

TEST(BlockSummary, TheChecksRmsIsThatOfTheirImageResiduals) {
  AdjustmentResult adjusted = ExampleAdjustment();
  EXPECT_EQ(Summarize(adjusted, {}).check_rms_px, adjusted.CheckRmsPx());
  EXPECT_TRUE(Summarize(adjusted, {}).check_rms_px);
  adjusted.checks.clear();
  EXPECT_EQ(Summarize(adjusted, {}).check_rms_px, std::nullopt);
  EXPECT_EQ(Summarize(adjusted, {}).checks, 0);
}

TEST(BlockSummary, OfNothingIsNothing) {
  const BlockSummary summary = Summarize({}, {});
  EXPECT_EQ(summary.photos + summary.by_neighbours + summary.ties + summary.sightings +
                summary.rejected + summary.checks,
            0);
  EXPECT_FALSE(summary.tie_sigma0_px || summary.check_rms_px);
}

}  // namespace
}  // namespace orient::block
