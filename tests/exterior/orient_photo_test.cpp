#include "exterior/orient_photo.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <numbers>
#include <string>
#include <vector>

#include "core/geometry/rotation.h"
#include "tests/support/textured_photo.h"

namespace orient::exterior {
namespace {

// A photo off by 10 m (5 pixels) and a degree or so.
class OrientPhotoOfTexture : public testing::Test {
 protected:
  ExteriorResult Orient(const std::vector<patchdb::Patch>& patches,
                        const OrientPhotoOptions& options = {}) {
    PhotoToOrient photo = world_.ToOrient();
    photo.prior.pose = world_.View().pose;
    photo.prior.pose.position_m += Eigen::Vector3d(8, -7, 5);
    photo.prior.pose.opk_rad += Eigen::Vector3d(0.015, -0.012, 0.02);
    Vector6d sigma;
    sigma << 10, 10, 10, 0.02, 0.02, 0.02;
    photo.prior.covariance = sigma.cwiseAbs2().asDiagonal();
    return OrientPhoto(photo, world_.File(), patches, options);
  }

  static int Matched(const ExteriorResult& result) {
    int count = 0;
    for (const PatchResult& patch : result.patches)
      count += patch.state == PatchState::kMatched ? 1 : 0;
    return count;
  }

  const TexturedPhoto world_{400, HillsAt, false};
};

TEST_F(OrientPhotoOfTexture, IsOkWithTwentyFivePatches) {
  const ExteriorResult result = Orient(world_.Patches(world_.Ground(), 2, 130));
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  EXPECT_GE(Matched(result), 20);
  const Vector6d off = PoseDifference(*result.pose, world_.View().pose);
  EXPECT_LT(off.head<3>().norm(), 1);
  EXPECT_LT(off.dot(result.covariance->ldlt().solve(off)), 22.5);  // 99.9 %
}

TEST_F(OrientPhotoOfTexture, OfNinePlacesIsWeakAsTheyDoNotTellHowPreciseItIs) {
  const std::vector<patchdb::Patch> all = world_.Patches(world_.Ground(), 2, 130);
  std::vector<patchdb::Patch> few;
  for (std::size_t i = 2; i < 22; i += 2) few.push_back(all[i]);
  const ExteriorResult result = Orient(few);
  EXPECT_EQ(result.status, Status::kWeak) << JoinedSentences(result.findings);
  EXPECT_GE(Matched(result), 7);
  EXPECT_TRUE(Has(result.findings, Reason::kFewPlaces));
}

// Fewer than half: the usual rounds do not ask for gradients.
TEST_F(OrientPhotoOfTexture, FindsThePatchesWhoseContrastHasTurnedByTheirGradients) {
  std::vector<patchdb::Patch> patches = world_.Patches(world_.Ground(), 2, 130);
  std::size_t inverted = 0;
  for (std::size_t i = 0; i < patches.size(); i += 4, ++inverted)
    for (float& value : patches[i].chip.values) value = 255 - value;
  const ExteriorResult result = Orient(patches);
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  std::size_t found = 0;
  for (const PatchResult& patch : result.patches)
    for (std::size_t i = 0; i < patches.size(); i += 4)
      found += patch.id == patches[i].id && patch.state == PatchState::kMatched ? 1 : 0;
  EXPECT_GE(2 * found, inverted);
}

// They move the projection centre up and down however well the patches agree: the control is no
// better, and the sigma tells it. Half of a variance is common.
TEST_F(OrientPhotoOfTexture, IsOkWhereTheHeightsOfTheControlAreWhatItLacks) {
  std::vector<patchdb::Patch> patches = world_.Patches(world_.Ground(), 2, 130);
  for (patchdb::Patch& patch : patches) {
    patch.height_effect = Eigen::Vector3d::UnitZ();
    patch.height_sigma_m = 12;
  }
  OrientPhotoOptions options;
  const ExteriorResult result = Orient(patches, options);
  EXPECT_EQ(result.status, Status::kOk) << JoinedSentences(result.findings);
  ASSERT_TRUE(result.projection_sigma && result.target_m);
  EXPECT_GT(result.projection_sigma->m, 2 * TexturedPhoto::kGsd_m);
  EXPECT_GT(*result.target_m, 2 * TexturedPhoto::kGsd_m);

  options.target_m = TexturedPhoto::kGsd_m;
  const ExteriorResult asked = Orient(patches, options);
  EXPECT_EQ(asked.status, Status::kWeak);
  EXPECT_TRUE(Has(asked.findings, Reason::kPoorlyDetermined));
}

TEST_F(OrientPhotoOfTexture, FailsOnPatchesOfAnotherPlace) {
  const ExteriorResult result = Orient(world_.Patches(Texture(6, 6), 2, 130));
  EXPECT_EQ(result.status, Status::kFailed);
  EXPECT_FALSE(result.pose);
}

}  // namespace
}  // namespace orient::exterior
