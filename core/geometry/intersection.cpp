#include "core/geometry/intersection.h"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

#include "core/geometry/dense_solvers.h"

namespace orient {
namespace {

// Rays whose normal matrix is worse conditioned are parallel (an angle of about 1e-6 rad).
constexpr double kParallel = 1e-12;
// The iteration ends when a step is this part of the distance to the cameras.
constexpr double kConverged = 1e-14;
constexpr int kMaxIterations = 30;

struct NormalEquations {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector2d> residuals_mm;
  double square_sum = 0;
};

std::optional<NormalEquations> Linearise(const std::vector<PhotoObservation>& photos,
                                         const Eigen::Vector3d& ground_m) {
  NormalEquations normal;
  for (const PhotoObservation& photo : photos) {
    const auto projected = PhotoFromGroundWithDerivatives(*photo.camera, photo.pose, ground_m);
    if (!projected) return std::nullopt;
    const Eigen::LLT<Eigen::Matrix2d> weight(photo.covariance_mm2);
    if (weight.info() != Eigen::Success)
      throw std::invalid_argument("the covariance of a photo observation is not positive definite");
    const Eigen::Vector2d residual = photo.photo_mm - projected->photo_mm;
    normal.matrix += projected->by_ground.transpose() * weight.solve(projected->by_ground);
    normal.right += projected->by_ground.transpose() * weight.solve(residual);
    normal.square_sum += residual.dot(weight.solve(residual));
    normal.residuals_mm.push_back(residual);
  }
  return normal;
}

}  // namespace

std::optional<Eigen::Vector3d> IntersectRays(const std::vector<Ray>& rays) {
  if (rays.size() < 2) return std::nullopt;
  const Eigen::Vector3d centre = rays.front().origin_m;
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Ray& ray : rays) {
    const Eigen::Matrix3d across =
        Eigen::Matrix3d::Identity() - ray.direction * ray.direction.transpose();
    matrix += across;
    right += across * (ray.origin_m - centre);
  }
  const Eigen::VectorXd eigenvalues = EigenOfSymmetric(matrix).values;
  if (!(eigenvalues[0] > kParallel * eigenvalues[2])) return std::nullopt;
  const Eigen::Vector3d point = centre + SolveNormal(matrix, right);
  for (const Ray& ray : rays)
    if (!(ray.direction.dot(point - ray.origin_m) > 0)) return std::nullopt;
  return point;
}

std::optional<IntersectionResult> IntersectPhotos(const std::vector<PhotoObservation>& photos) {
  std::vector<Ray> rays;
  for (const PhotoObservation& photo : photos) {
    const auto ray = GroundRayFromPhoto(*photo.camera, photo.pose, photo.photo_mm);
    if (!ray) return std::nullopt;
    rays.push_back(*ray);
  }
  auto ground_m = IntersectRays(rays);
  if (!ground_m) return std::nullopt;
  const double distance_m = (*ground_m - rays.front().origin_m).norm();
  double last_step = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kMaxIterations; ++i) {
    const auto normal = Linearise(photos, *ground_m);
    if (!normal) return std::nullopt;
    const Eigen::Matrix3d inverse = normal->matrix.inverse();
    if (!inverse.allFinite()) return std::nullopt;
    const Eigen::Vector3d step = inverse * normal->right;
    const double size = step.norm();
    // At the limit of the arithmetic steps stop getting smaller.
    if (size <= kConverged * distance_m || (size < 1e-9 * distance_m && size >= last_step)) {
      IntersectionResult result{*ground_m, inverse, normal->residuals_mm};
      result.degrees_of_freedom = static_cast<int>(2 * photos.size()) - 3;
      result.sigma0 = std::sqrt(normal->square_sum / result.degrees_of_freedom);
      return result;
    }
    last_step = size;
    *ground_m += step;
  }
  return std::nullopt;
}

}  // namespace orient
