#include "tools/report/figures/adjustment_figures.h"

#include <gtest/gtest.h>

#include "tests/support/example_adjustment.h"

namespace orient {
namespace {

TEST(AdjustmentFigures, CountOnlyWhatIsUsed) {
  const SightingsByPhoto photos = SightingsOf(ExampleAdjustment());
  const PhotoSightings& photo = photos.at("4712");
  EXPECT_EQ(photo.ties, 2);
  EXPECT_EQ(photo.ties_used, 1);
  EXPECT_NEAR(*photo.RmsPx(), 0.4, 1e-12);
  EXPECT_NEAR(*photo.MeanRedundancy(), 0.3, 1e-12);
  EXPECT_EQ(photos.at("4711").control_used, 1);
}

TEST(AdjustmentFigures, NameThePhotosThatAreWorst) {
  const WorstPhotos worst = WorstOf(SightingsOf(ExampleAdjustment()));
  EXPECT_EQ(worst.by_w, "4711");
  EXPECT_EQ(worst.by_rms, "4712");
  EXPECT_EQ(WorstOf({}).by_w, "");
  EXPECT_EQ(WorstOf({{"4713", {}}}).by_rms, "") << "it uses nothing";
}

TEST(AdjustmentFigures, ResidualsOnTheGroundAreOfUsedControlOnly) {
  AdjustmentResult adjusted = ExampleAdjustment();
  adjusted.control.push_back(adjusted.control.front());
  adjusted.control.back().control->state = "rejected";
  const GroundResiduals control = ResidualsOfControl(adjusted);
  EXPECT_EQ(control.Count(), 1);
  EXPECT_NEAR(control.Le90_m(), 1.6449 * 0.2, 1e-12);
  EXPECT_EQ(ResidualsOfGnss(adjusted).Count(), 0);
}

}  // namespace
}  // namespace orient
