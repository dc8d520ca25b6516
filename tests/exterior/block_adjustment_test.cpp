#include "exterior/block_adjustment.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdio>

#include "tools/bench/bundle_simulation.h"

namespace orient {
namespace {

// What an adjustment is worth, as the truth tells it.
struct Verdict {
  double horizontal_gsd = 0, height_gsd = 0;  // RMS of one coordinate over all ties
  double worst_photo_horizontal = 0, worst_photo_height = 0;
  double pose_chi = 0, point_chi = 0;  // RMS of normalised errors
};

Verdict Judge(const BundleSimulation& truth, const BlockResult& result) {
  Verdict verdict;
  std::vector<Eigen::Vector3d> of_photo(truth.true_poses.size(), Eigen::Vector3d::Zero());
  std::vector<int> points_of_photo(truth.true_poses.size(), 0);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int points = 0, adjusted = 0;
  for (std::size_t i = 0; i < result.points.size(); ++i) {
    if (!result.points[i].adjusted || truth.block.points[i].control) continue;
    const Eigen::Vector3d off = result.points[i].ground_m - truth.true_ground[i];
    sum += off.cwiseAbs2();
    verdict.point_chi += off.dot(result.points[i].covariance_m2.inverse() * off) / 3;
    ++points;
  }
  for (std::size_t i = 0; i < result.observations.size(); ++i) {
    const ImageObservation& o = truth.block.observations[i];
    if (result.observations[i].state != ObservationState::kUsed) continue;
    of_photo[o.photo] += (result.points[o.point].ground_m - truth.true_ground[o.point]).cwiseAbs2();
    ++points_of_photo[o.photo];
  }
  for (std::size_t i = 0; i < of_photo.size(); ++i) {
    const Eigen::Vector3d rms = (of_photo[i] / points_of_photo[i]).cwiseSqrt() / truth.gsd_m;
    verdict.worst_photo_horizontal =
        std::max(verdict.worst_photo_horizontal, std::sqrt(rms.head<2>().squaredNorm() / 2));
    verdict.worst_photo_height = std::max(verdict.worst_photo_height, rms.z());
    if (result.photos[i].state != PhotoState::kAdjusted) continue;
    const Vector6d off = PoseDifference(result.photos[i].pose, truth.true_poses[i]);
    verdict.pose_chi += off.dot(result.photos[i].covariance.inverse() * off) / 6;
    ++adjusted;
  }
  verdict.horizontal_gsd = std::sqrt(sum.head<2>().sum() / 2 / points) / truth.gsd_m;
  verdict.height_gsd = std::sqrt(sum.z() / points) / truth.gsd_m;
  verdict.point_chi = std::sqrt(verdict.point_chi / points);
  verdict.pose_chi = std::sqrt(verdict.pose_chi / adjusted);
  return verdict;
}

TEST(BlockAdjustment, CarriesControlUnderFourPhotosThroughTheWholeBlock) {
  const BundleSimulation simulation = SimulateBundle();
  const BlockResult result = AdjustBlock(simulation.block);
  const Verdict verdict = Judge(simulation, result);
  EXPECT_LT(verdict.worst_photo_horizontal, 0.6);
  EXPECT_LT(verdict.worst_photo_height, 0.9);
  EXPECT_NEAR(result.sigma0, 1, 0.05);
}

}  // namespace
}  // namespace orient
