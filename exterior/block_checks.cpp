// Held-out control patches: what the adjusted block says of places that it was told nothing of.
#include <Eigen/Dense>
#include <cmath>
#include <map>

#include "core/geometry/intersection.h"
#include "exterior/block_outcome.h"

namespace orient {
namespace {

// How the poses of any two photos err together.
class JointPoses {
 public:
  JointPoses(const BlockSystem& system, const BlockNormals& normals, const BlockResult& result)
      : system_(&system), normals_(&normals), all_(&result.pose_covariance) {
    for (std::size_t k = 0; k < result.covariance_photos.size(); ++k)
      place_[result.covariance_photos[k]] = 6 * static_cast<Eigen::Index>(k);
  }
  // Of a block that is too large for all poses' covariance, zero where the photos have no point in
  // common.
  Matrix6d Of(std::size_t a, std::size_t b) const {
    if (place_.contains(a) && place_.contains(b))
      return all_->block<6, 6>(place_.at(a), place_.at(b));
    return normals_->cholesky()
        .InverseIfThere(system_->pose_group[a], system_->pose_group[b])
        .value_or(Matrix6d::Zero());
  }

 private:
  const BlockSystem* system_;
  const BlockNormals* normals_;
  const Eigen::MatrixXd* all_;
  std::map<std::size_t, Eigen::Index> place_;
};

// The intersected point's covariance: of its image points, and of the poses.
Eigen::Matrix3d GroundCovariance(const JointPoses& poses, const std::vector<PhotoObservation>& seen,
                                 const std::vector<std::size_t>& photos,
                                 const Eigen::Vector3d& ground_m) {
  Eigen::Matrix3d V = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Matrix<double, 3, 6>> by_pose;
  for (const PhotoObservation& o : seen) {
    const auto d = PhotoFromGroundWithDerivatives(*o.camera, o.pose, ground_m);
    if (!d) return Eigen::Matrix3d::Zero();
    const Eigen::Matrix<double, 3, 2> weighted =
        d->by_ground.transpose() * o.covariance_mm2.inverse();
    V += weighted * d->by_ground;
    by_pose.push_back(-weighted * d->by_pose);
  }
  const Eigen::Matrix3d inverse = V.inverse();
  Eigen::Matrix3d covariance = inverse;
  for (std::size_t a = 0; a < seen.size(); ++a)
    for (std::size_t b = 0; b < seen.size(); ++b)
      covariance += inverse * by_pose[a] * poses.Of(photos[a], photos[b]) * by_pose[b].transpose() *
                    inverse.transpose();
  return covariance;
}

void Intersect(const BlockSystem& system, const JointPoses& poses, const BlockResult& result,
               CheckPatch* check) {
  std::vector<PhotoObservation> seen;
  std::vector<std::size_t> photos;
  for (const std::size_t i : check->observations) {
    const std::size_t photo = system.block.observations[i].photo;
    const PhotoView view = AdjustedView(system.block, result, photo);
    seen.push_back({&result.cameras[system.block.photos[photo].camera], view.pose,
                    view.PhotoFromPixel(system.block.observations[i].pixel),
                    system.ImageCovariance(i) * system.PrecisionFactor(RowKind::kControlImage)});
    photos.push_back(photo);
  }
  const auto met = IntersectPhotos(seen);
  if (!met) return;
  const GroundControl& control = *system.block.points[check->point].control;
  check->ground_residual_m = control.ground_m - met->ground_m;
  const Eigen::Vector3d by_heights = control.height_effect * control.height_sigma_m;
  check->ground_covariance_m2 =
      GroundCovariance(poses, seen, photos, met->ground_m) +
      control.covariance_m2 * system.PrecisionFactor(RowKind::kControlGround) +
      by_heights * by_heights.transpose();
  const Eigen::Vector3d& off = *check->ground_residual_m;
  check->normalised = std::sqrt(off.dot(check->ground_covariance_m2.ldlt().solve(off)) / 3);
}

}  // namespace

void FillChecks(const BlockSystem& system, const BlockNormals& normals, BlockResult* result) {
  std::vector<CheckPatch> checks(system.points.size());
  for (std::size_t i = 0; i < system.block.observations.size(); ++i) {
    const ImageObservation& o = system.block.observations[i];
    const BlockPoint& point = system.block.points[o.point];
    if (!point.held_out || !point.control) continue;
    if (result->photos[o.photo].state != PhotoState::kAdjusted) continue;
    const PhotoView view = AdjustedView(system.block, *result, o.photo);
    const auto pixel = view.PixelFromGround(point.control->ground_m);
    if (!pixel) continue;
    checks[o.point].observations.push_back(i);
    checks[o.point].image_residuals_px.emplace_back(o.pixel - *pixel);
    result->observations[i].residual_px = o.pixel - *pixel;
  }
  const JointPoses poses(system, normals, *result);
  for (std::size_t i = 0; i < checks.size(); ++i) {
    if (checks[i].observations.empty()) continue;
    checks[i].point = i;
    checks[i].rays = static_cast<int>(checks[i].observations.size());
    if (checks[i].rays > 1) Intersect(system, poses, *result, &checks[i]);
    result->checks.push_back(std::move(checks[i]));
  }
}

}  // namespace orient
