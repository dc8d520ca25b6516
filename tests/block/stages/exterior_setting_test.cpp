#include "block/stages/exterior_setting.h"

#include <gtest/gtest.h>

#include <cmath>

namespace orient::block {
namespace {

ExteriorRunOptions OfOnePhoto() {
  ExteriorRunOptions options;
  options.photos = {"4711.tif"};
  return options;
}

// Whether it is wrong, and the message names `option`.
bool IsWrong(const ExteriorRunOptions& options, const std::string& option) {
  const auto wrong = options.Check();
  if (wrong) {
    EXPECT_NE(wrong->find(option), std::string::npos) << *wrong;
  }
  return wrong.has_value();
}

TEST(ExteriorRunOptions, OfOnePhotoAreRightAsTheyAre) {
  EXPECT_EQ(OfOnePhoto().Check(), std::nullopt);
}

TEST(ExteriorRunOptions, OfNoPhotoAreWrong) { EXPECT_TRUE(IsWrong({}, "no photo")); }

TEST(ExteriorRunOptions, APositionsSigmaIsPositiveAndAtMostAThousandKilometres) {
  ExteriorRunOptions options = OfOnePhoto();
  for (const double right : {1e-3, 10.0, 1e6}) {
    options.position_sigma_m = right;
    EXPECT_FALSE(IsWrong(options, "position-sigma-m")) << right;
  }
  for (const double wrong : {0.0, -1.0, 1.000001e6, std::nan("")}) {
    options.position_sigma_m = wrong;
    EXPECT_TRUE(IsWrong(options, "position-sigma-m")) << wrong;
  }
}

TEST(ExteriorRunOptions, AnAnglesSigmaIsPositiveAndAtMostHalfATurn) {
  for (const auto& [sigma, option] :
       {std::pair(&ExteriorRunOptions::attitude_sigma_rad, "attitude-sigma-deg"),
        {&ExteriorRunOptions::kappa_sigma_rad, "kappa-sigma-deg"}}) {
    ExteriorRunOptions options = OfOnePhoto();
    for (const double right : {1e-6, 0.05, 3.1415927}) {
      options.*sigma = right;
      EXPECT_FALSE(IsWrong(options, option)) << right;
    }
    for (const double wrong : {0.0, -0.1, 3.3, std::nan("")}) {
      options.*sigma = wrong;
      EXPECT_TRUE(IsWrong(options, option)) << wrong;
    }
  }
}

TEST(ExteriorRunOptions, APrincipalDistancesSigmaIsPositive) {
  ExteriorRunOptions options = OfOnePhoto();
  options.principal_distance_sigma_mm = 0.1;
  EXPECT_FALSE(IsWrong(options, "principal-distance-sigma-mm"));
  for (const double wrong : {0.0, -0.1, std::nan("")}) {
    options.principal_distance_sigma_mm = wrong;
    EXPECT_TRUE(IsWrong(options, "principal-distance-sigma-mm")) << wrong;
  }
}

TEST(ExteriorRunOptions, JobsAreNotNegative) {
  ExteriorRunOptions options = OfOnePhoto();
  options.jobs = 0;
  EXPECT_FALSE(IsWrong(options, "jobs"));
  options.jobs = -1;
  EXPECT_TRUE(IsWrong(options, "jobs"));
}

}  // namespace
}  // namespace orient::block
