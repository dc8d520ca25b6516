#include "exterior/steps/patch_observation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/matching/least_squares_matching.h"
#include "exterior/steps/error_model.h"
#include "exterior/steps/linearised_matches.h"
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
  const double model = kMatchModelSigma_px * kMatchModelSigma_px;
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

// A spot height: known to centimetres in plan, to metres in height, and not under the photo.
TEST(PatchObservation, ASurveyedPointLeavesItsMatchWhatIsTheMatchsOwn) {
  const PhotoView view = DigitalView();
  patchdb::Patch patch;
  patch.ground_m = {-200, -100, 500};
  const Eigen::Matrix2d match = 0.01 * Eigen::Matrix2d::Identity();
  const double own_px2 = OwnVariance(ObservationOf(patch, {10, 20}, match, view));
  patch.covariance_m2 = Eigen::Vector3d(0.01, 0.01, 900).asDiagonal();
  const PatchObservation surveyed = ObservationOf(patch, {10, 20}, match, view);
  EXPECT_GT(surveyed.covariance_px2.trace(), 10 * own_px2);
  EXPECT_GE(surveyed.ground_px2, 0);
  EXPECT_NEAR(OwnVariance(surveyed) - surveyed.ground_px2, own_px2, 1e-9);
}

// A photo's patch moves up with the heights it was cut with; an orthophoto's stays where it is, and
// the surface errs by itself.
TEST(PatchObservation, OnlyAnOrthophotosSurfaceErrsByItself) {
  const PhotoView view = DigitalView();
  patchdb::Patch patch;
  patch.ground_m = {1000, 2000, 500};
  patch.covariance_m2 = Eigen::Vector3d(4, 4, 9).asDiagonal();
  patch.height_sigma_m = 3;
  patch.height_effect = Eigen::Vector3d(0.1, 0, 1);
  const Eigen::Matrix2d match = 0.01 * Eigen::Matrix2d::Identity();
  const PatchObservation of_photo = ObservationOf(patch, {10, 20}, match, view);
  EXPECT_EQ(of_photo.surface_sigma_m, 0);
  EXPECT_EQ(of_photo.source_sigma_px, 0);
  patch.height_effect = Eigen::Vector3d(0.1, 0, 0);
  const PatchObservation of_orthophoto = ObservationOf(patch, {10, 20}, match, view);
  EXPECT_NEAR(of_orthophoto.surface_sigma_m, 3, 1e-12);
  // Known by the rays of two photos, seven times as well as by heights.
  patch.height_effect = Eigen::Vector3d(0.02, 0, 0.14);
  patch.covariance_m2(2, 2) = 0.14 * 9;
  const PatchObservation of_two_photos = ObservationOf(patch, {10, 20}, match, view);
  EXPECT_EQ(of_two_photos.surface_sigma_m, 0);
  EXPECT_EQ(of_two_photos.source_sigma_px, 0);
  // The part of two metres in either coordinate that its heights do not explain.
  const double metres = kSharedBySource * std::sqrt((4 - 0.09 + 4) / 2);
  EXPECT_NEAR(of_orthophoto.source_sigma_px, metres / view.GroundPixel(500), 1e-9);
}

}  // namespace
}  // namespace orient::exterior
