#include "tools/report/figures/photo_accuracy.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/geometry/bounds.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient {
namespace {

constexpr double kLargestCoordinate_m = 1e8;  // no projected CRS has larger ones

// Level ground that extends beyond the footprint by its width: the frame shows another area on it
// than on the true ground.
std::optional<GroundSurface> LevelGround(const std::vector<Eigen::Vector3d>& footprint_m) {
  Bounds bounds = Bounds::OfNothing();
  double height_m = 0;
  for (const Eigen::Vector3d& corner : footprint_m) {
    if (!(corner.cwiseAbs().maxCoeff() < kLargestCoordinate_m)) return std::nullopt;
    bounds.Include(corner.x(), corner.y());
    height_m += corner.z() / static_cast<double>(footprint_m.size());
  }
  const double side = std::max(bounds.max_x - bounds.min_x, bounds.max_y - bounds.min_y);
  if (!(side > 0)) return std::nullopt;
  constexpr int kNodes = 5;  // the outermost lie one side beyond the footprint
  return GroundSurface::FromGrid(
      Eigen::MatrixXf::Constant(kNodes, kNodes, static_cast<float>(height_m)),
      bounds.min_x - 1.5 * side, bounds.max_y + 1.5 * side, side);
}

}  // namespace

std::optional<GroundAccuracy> AccuracyOnLevelGround(const ExteriorResult& photo,
                                                    const Camera& camera) {
  if (!photo.pose || !photo.covariance || photo.footprint_m.size() < 3) return std::nullopt;
  const auto ground = LevelGround(photo.footprint_m);
  if (!ground || !photo.covariance->allFinite()) return std::nullopt;
  PhotoView view;  // in photo coordinates: where the scan's pixels lie does not matter
  view.camera = camera;
  if (photo.principal_distance)
    view.camera.principal_distance_mm = photo.principal_distance->value_mm;
  view.pose = *photo.pose;
  const auto accuracy = AccuracyOf(view, *photo.covariance, *ground, 0);
  if (!accuracy || !std::isfinite(accuracy->worst_m)) return std::nullopt;
  return accuracy;
}

}  // namespace orient
