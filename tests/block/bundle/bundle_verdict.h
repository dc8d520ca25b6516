// What an adjustment of a simulated block is worth, as the truth tells it.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "block/bundle/adjustment.h"
#include "tools/bench/bundle_simulation.h"

namespace orient::block {

// RMS of one coordinate, in ground pixels, over ties none of whose rays is a gross error;
// normalised errors as sums of chi-square, so that several blocks can be taken together.
struct BundleVerdict {
  double horizontal_gsd = 0, height_gsd = 0;
  double worst_photo_horizontal = 0, worst_photo_height = 0;
  double pose_chi2 = 0, point_chi2 = 0;
  int poses = 0, points = 0;  // chi-square's degrees of freedom: six and three each
  int gross = 0, gross_named = 0, wrongly_named = 0;
  // All gross errors but those of single rays, which are no ties. Two rays of a tie show an error
  // across their base only: those count here, too, and some of them cannot be named.
  int findable = 0, findable_named = 0;

  double PoseChi() const { return std::sqrt(pose_chi2 / (6 * poses)); }
  double PointChi() const { return std::sqrt(point_chi2 / (3 * points)); }
  void Add(const BundleVerdict& other) {
    pose_chi2 += other.pose_chi2;
    point_chi2 += other.point_chi2;
    poses += other.poses;
    points += other.points;
    gross += other.gross;
    gross_named += other.gross_named;
    wrongly_named += other.wrongly_named;
    findable += other.findable;
    findable_named += other.findable_named;
  }
};

class BundleJudge {
 public:
  BundleJudge(const BundleSimulation& truth, const BlockResult& result)
      : truth_(truth),
        result_(result),
        spoilt_(result.points.size(), false),
        rays_(result.points.size(), 0) {
    for (std::size_t i = 0; i < truth.gross.size(); ++i) {
      ++rays_[truth.block.observations[i].point];
      if (truth.gross[i]) spoilt_[truth.block.observations[i].point] = true;
    }
  }

  BundleVerdict Verdict() {
    Points();
    Photos();
    GrossErrors();
    return verdict_;
  }

 private:
  bool Counts(std::size_t point) const {
    return result_.points[point].adjusted && !truth_.block.points[point].control && !spoilt_[point];
  }
  Eigen::Vector3d Off(std::size_t point) const {
    return result_.points[point].ground_m - truth_.true_ground[point];
  }

  void Points() {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i < result_.points.size(); ++i) {
      if (!Counts(i)) continue;
      sum += Off(i).cwiseAbs2();
      verdict_.point_chi2 += Off(i).dot(result_.points[i].covariance_m2.inverse() * Off(i));
      ++verdict_.points;
    }
    verdict_.horizontal_gsd = std::sqrt(sum.head<2>().sum() / 2 / verdict_.points) / truth_.gsd_m;
    verdict_.height_gsd = std::sqrt(sum.z() / verdict_.points) / truth_.gsd_m;
  }

  void Photos() {
    std::vector<Eigen::Vector3d> sums(truth_.true_poses.size(), Eigen::Vector3d::Zero());
    std::vector<int> seen(sums.size(), 0);
    for (std::size_t i = 0; i < result_.observations.size(); ++i) {
      const ImageObservation& o = truth_.block.observations[i];
      if (result_.observations[i].state != ObservationState::kUsed || !Counts(o.point)) continue;
      sums[o.photo] += Off(o.point).cwiseAbs2();
      ++seen[o.photo];
    }
    for (std::size_t i = 0; i < sums.size(); ++i) {
      if (result_.photos[i].state != PhotoState::kAdjusted) continue;
      const Eigen::Vector3d rms = (sums[i] / seen[i]).cwiseSqrt() / truth_.gsd_m;
      verdict_.worst_photo_horizontal =
          std::max(verdict_.worst_photo_horizontal, rms.head<2>().norm() / std::sqrt(2.0));
      verdict_.worst_photo_height = std::max(verdict_.worst_photo_height, rms.z());
      const Vector6d off = PoseDifference(result_.photos[i].pose, truth_.true_poses[i]);
      verdict_.pose_chi2 += off.dot(result_.photos[i].covariance.inverse() * off);
      ++verdict_.poses;
    }
  }

  void GrossErrors() {
    for (std::size_t i = 0; i < truth_.gross.size(); ++i) {
      const std::size_t point = truth_.block.observations[i].point;
      const bool named = result_.observations[i].state == ObservationState::kRejected ||
                         result_.points[point].control_rejected;
      const bool findable = rays_[point] > 1 || truth_.block.points[point].control.has_value();
      if (!truth_.gross[i]) {
        verdict_.wrongly_named += named ? 1 : 0;
        continue;
      }
      ++verdict_.gross;
      verdict_.gross_named += named ? 1 : 0;
      verdict_.findable += findable ? 1 : 0;
      verdict_.findable_named += findable && named ? 1 : 0;
    }
  }

  const BundleSimulation& truth_;
  const BlockResult& result_;
  std::vector<bool> spoilt_;
  std::vector<int> rays_;
  BundleVerdict verdict_;
};

inline BundleVerdict JudgeBundle(const BundleSimulation& truth, const BlockResult& result) {
  return BundleJudge(truth, result).Verdict();
}

inline BundleSimulationOptions SmallBlock(unsigned seed = 1) {
  BundleSimulationOptions options;
  options.ties_per_photo = 40;
  options.seed = seed;
  return options;
}

}  // namespace orient::block
