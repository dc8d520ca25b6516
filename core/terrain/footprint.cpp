#include "core/terrain/footprint.h"

#include <array>

namespace orient {

std::vector<Eigen::Vector3d> Footprint(const PhotoView& view, const GroundSurface& surface) {
  constexpr int kPointsPerSide = 6;
  const Eigen::Vector2d half = view.camera.frame_mm / 2;
  const std::array<Eigen::Vector2d, 4> corners = {Eigen::Vector2d(-1, -1), Eigen::Vector2d(1, -1),
                                                  Eigen::Vector2d(1, 1), Eigen::Vector2d(-1, 1)};
  std::vector<Eigen::Vector3d> ring;
  for (std::size_t side = 0; side < 4; ++side)
    for (int i = 0; i < kPointsPerSide; ++i) {
      const Eigen::Vector2d unit =
          corners[side] + (corners[(side + 1) % 4] - corners[side]) * i / kPointsPerSide;
      const auto ray = GroundRayFromPhoto(view.camera, view.pose,
                                          view.camera.frame_centre_mm + half.cwiseProduct(unit));
      if (!ray || ray->direction.z() > -1e-3) return {};
      const double to_mean = (surface.MeanHeight() - ray->origin_m.z()) / ray->direction.z();
      ring.push_back(surface.Intersect(*ray).value_or(ray->origin_m + ray->direction * to_mean));
    }
  ring.push_back(ring.front());
  return ring;
}

}  // namespace orient
