#include "exterior/steps/patch_observation.h"

#include <gtest/gtest.h>

#include "exterior/steps/error_model.h"
#include "tests/exterior/digital_view.h"

namespace orient::exterior {
namespace {

// Where nothing is known of a patch's heights its own covariance is what it errs; where it is, the
// heights' share is an error that it has in common with others.
TEST(PatchObservation, GroundErrsByItselfUnlessItsHeightsAreKnownToErr) {
  const PhotoView view = DigitalView();
  patchdb::Patch patch;
  patch.source_id = 7;
  patch.ground_m = {1000, 2000, 500};
  patch.covariance_m2 = 4 * Eigen::Matrix3d::Identity();
  const Eigen::Matrix2d match = 0.01 * Eigen::Matrix2d::Identity();
  const double model = kModelSigmaPx * kModelSigmaPx;
  const PatchObservation alone = ObservationOf(patch, {10, 20}, match, view);
  // Two metres from 4500 m, c 120 mm, pixels of 92 mm / 640.
  const double ground_px = 2.0 / 4500 * 120 / (92.0 / 640);
  EXPECT_NEAR(alone.covariance_px2(0, 0), 0.01 + model + ground_px * ground_px, 0.01);
  EXPECT_EQ(alone.height_sigma_m, 0);
  EXPECT_EQ(alone.source, 7);
  patch.height_effect = Eigen::Vector3d(0.1, 0, 1);
  patch.height_sigma_m = 2;
  const PatchObservation shared = ObservationOf(patch, {10, 20}, match, view);
  EXPECT_NEAR(shared.covariance_px2(0, 0), 0.01 + model, 1e-12);
  EXPECT_EQ(shared.height_effect, Eigen::Vector3d(0.1, 0, 1));
  EXPECT_EQ(shared.height_sigma_m, 2);
}

}  // namespace
}  // namespace orient::exterior
