#include "core/geometry/collinearity.h"

#include <Eigen/Geometry>
#include <cmath>

namespace orient {

PosedCamera::PosedCamera(const Camera& camera, const Pose& pose)
    : camera_(camera),
      photo_from_ground_(pose.GroundFromPhoto().transpose()),
      position_m_(pose.position_m),
      phi_axis_(std::sin(pose.opk_rad[2]), std::cos(pose.opk_rad[2]), 0) {}

std::optional<Eigen::Vector2d> PosedCamera::PhotoFromGround(const Eigen::Vector3d& ground_m) const {
  const Eigen::Vector3d d = photo_from_ground_ * (ground_m - position_m_);
  if (!(d.z() < 0)) return std::nullopt;
  const Eigen::Vector2d ideal = d.head<2>() * (-camera_.principal_distance_mm / d.z());
  if (!InsideFold(camera_.lens, ideal)) return std::nullopt;
  return camera_.principal_point_mm + DistortPoint(camera_.lens, ideal);
}

std::optional<Eigen::Vector2d> PhotoFromGround(const Camera& camera, const Pose& pose,
                                               const Eigen::Vector3d& ground_m) {
  return PosedCamera(camera, pose).PhotoFromGround(ground_m);
}

std::optional<ProjectionDerivatives> PosedCamera::PhotoFromGroundWithDerivatives(
    const Eigen::Vector3d& ground_m) const {
  const Eigen::Vector3d d = photo_from_ground_ * (ground_m - position_m_);
  if (!(d.z() < 0)) return std::nullopt;
  const double c = camera_.principal_distance_mm;
  const Eigen::Vector2d slope = -d.head<2>() / d.z();
  const Eigen::Vector2d ideal = c * slope;
  if (!InsideFold(camera_.lens, ideal)) return std::nullopt;

  const Eigen::Matrix2d measured_by_ideal =
      Eigen::Matrix2d::Identity() + DistortionJacobian(camera_.lens, ideal);
  Eigen::Matrix<double, 2, 3> ideal_by_d;
  ideal_by_d << -c / d.z(), 0, -ideal.x() / d.z(),  //
      0, -c / d.z(), -ideal.y() / d.z();
  const Eigen::Matrix<double, 2, 3> by_d = measured_by_ideal * ideal_by_d;

  ProjectionDerivatives result;
  result.photo_mm = camera_.principal_point_mm + DistortPoint(camera_.lens, ideal);
  result.by_ground = by_d * photo_from_ground_;
  result.by_pose.leftCols<3>() = -result.by_ground;
  // A small rotation of the camera about an axis changes d by d x axis. Omega's is the ground's x,
  // kappa's the photo's z.
  result.by_pose.col(3) = by_d * d.cross(photo_from_ground_.col(0));
  result.by_pose.col(4) = by_d * d.cross(phi_axis_);
  result.by_pose.col(5) = by_d * d.cross(Eigen::Vector3d::UnitZ());
  result.by_principal_distance = measured_by_ideal * slope;
  return result;
}

std::optional<ProjectionDerivatives> PhotoFromGroundWithDerivatives(
    const Camera& camera, const Pose& pose, const Eigen::Vector3d& ground_m) {
  return PosedCamera(camera, pose).PhotoFromGroundWithDerivatives(ground_m);
}

std::optional<Ray> GroundRayFromPhoto(const Camera& camera, const Pose& pose,
                                      const Eigen::Vector2d& photo_mm) {
  const auto ideal = UndistortPoint(camera.lens, photo_mm - camera.principal_point_mm);
  if (!ideal) return std::nullopt;
  const Eigen::Vector3d direction(ideal->x(), ideal->y(), -camera.principal_distance_mm);
  return Ray{pose.position_m, pose.GroundFromPhoto() * direction.normalized()};
}

}  // namespace orient
