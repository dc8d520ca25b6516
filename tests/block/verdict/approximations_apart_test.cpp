#include "block/verdict/approximations_apart.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

namespace orient::block {
namespace {

constexpr double kSigma_m = 10;

// Photos whose approximations err by their sigma and lie apart from the poses by `apart_m`.
std::vector<ExteriorResult> Photos(int count, const Eigen::Vector3d& apart_m, unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0, kSigma_m);
  std::vector<ExteriorResult> results(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < results.size(); ++i) {
    Pose pose;
    pose.position_m = {5e5 + 1000.0 * static_cast<double>(i), 5e6, 3000};
    StartingPose approximation{pose, {}};
    approximation.sigma << kSigma_m, kSigma_m, kSigma_m, 0.05, 0.05, std::numbers::pi;
    for (double& coordinate : approximation.pose.position_m) coordinate += normal(random);
    approximation.pose.position_m -= apart_m;
    results[i].pose = pose;
    results[i].approximation = approximation;
  }
  return results;
}

TEST(ApproximationsApart, AHeightDatumIsNamedThoughNoPhotoAloneContradictsItsOwn) {
  const auto finding = ApproximationsApart(Photos(6, {0, 0, 45}));
  ASSERT_TRUE(finding);
  EXPECT_EQ(finding->reason, Reason::kApproximationsWorseThanStated);
  EXPECT_EQ(finding->at_best, Status::kOk) << "which of them is wrong is not known";
  EXPECT_NEAR(*finding->value, 4.5, 1.2);
  EXPECT_NE(finding->where.find("of 6 photos"), std::string::npos) << finding->where;
}

TEST(ApproximationsApart, OfRightOnesNothingIsSaid) {
  for (unsigned seed = 0; seed < 1000; ++seed)
    EXPECT_FALSE(ApproximationsApart(Photos(3 + static_cast<int>(seed % 50), {0, 0, 0}, seed)));
}

TEST(ApproximationsApart, OfManyPhotosASmallShiftIsWithinTheirAccuracy) {
  EXPECT_FALSE(ApproximationsApart(Photos(400, {0, 10, 0})));
  EXPECT_TRUE(ApproximationsApart(Photos(400, {0, 20, 0})));
}

TEST(ApproximationsApart, WhereTheyScatterAsMuchNothingIsSaidOfAShift) {
  std::vector<ExteriorResult> photos = Photos(6, {0, 0, 45});
  for (std::size_t i = 0; i < photos.size(); i += 2) photos[i].pose->position_m.z() -= 90;
  EXPECT_FALSE(ApproximationsApart(photos));
}

TEST(ApproximationsApart, TwoPhotosOrNoneSayNothing) {
  EXPECT_FALSE(ApproximationsApart({}));
  EXPECT_FALSE(ApproximationsApart(Photos(2, {0, 0, 450})));
  std::vector<ExteriorResult> photos = Photos(6, {0, 0, 45});
  for (std::size_t i = 2; i < photos.size(); ++i) photos[i].pose.reset();
  EXPECT_FALSE(ApproximationsApart(photos));
}

}  // namespace
}  // namespace orient::block
