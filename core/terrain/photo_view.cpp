#include "core/terrain/photo_view.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/terrain/ground_surface.h"

namespace orient {

std::optional<Eigen::Vector2d> PhotoView::PixelFromGround(const Eigen::Vector3d& ground_m) const {
  const auto photo_mm = PhotoFromGround(camera, pose, ground_m);
  if (!photo_mm) return std::nullopt;
  return PixelFromPhoto(*photo_mm);
}

std::optional<Eigen::Vector3d> PhotoView::GroundFromPixel(const Eigen::Vector2d& pixel,
                                                          const GroundSurface& surface) const {
  const auto ray = GroundRayFromPhoto(camera, pose, PhotoFromPixel(pixel));
  if (!ray) return std::nullopt;
  return surface.Intersect(*ray);
}

double PhotoView::PixelSize() const {
  return std::sqrt(std::abs(photo_from_pixel.A.determinant()));
}

double PhotoView::GroundPixel(double height_m) const {
  return PixelSize() / camera.principal_distance_mm * std::abs(pose.position_m.z() - height_m);
}

std::optional<Bounds> FootprintBounds(const Camera& camera, const Pose& pose, double min_height_m,
                                      double max_height_m) {
  constexpr int kPointsAlongSide = 8;
  const double highest = std::min(max_height_m, pose.position_m.z());
  if (min_height_m > highest) return std::nullopt;
  Bounds bounds = Bounds::OfNothing();
  for (int i = 0; i < 4 * kPointsAlongSide; ++i) {
    // Once around the frame: along one of the sides at a time.
    const double along = -0.5 + (i % kPointsAlongSide) / static_cast<double>(kPointsAlongSide);
    const int side = i / kPointsAlongSide;
    const double sign = side % 2 == 0 ? 1 : -1;
    const Eigen::Vector2d part = side < 2 ? Eigen::Vector2d(sign * along, sign * 0.5)
                                          : Eigen::Vector2d(sign * -0.5, sign * along);
    const auto ray = GroundRayFromPhoto(
        camera, pose, camera.frame_centre_mm + part.cwiseProduct(camera.frame_mm));
    if (!ray || !(ray->direction.z() < 0)) return std::nullopt;
    for (const double height : {min_height_m, highest}) {
      const double distance = (height - ray->origin_m.z()) / ray->direction.z();
      const Eigen::Vector3d point = ray->origin_m + distance * ray->direction;
      bounds.Include(point.x(), point.y());
    }
  }
  return bounds;
}

}  // namespace orient
