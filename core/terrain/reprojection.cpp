#include "core/terrain/reprojection.h"

#include <cmath>

namespace orient {

double ReprojectionRms(const PhotoView& truth, const Pose& pose, int width_px, int height_px,
                       const GroundSurface& surface) {
  constexpr int kGrid = 20;
  PhotoView other = truth;
  other.pose = pose;
  double sum = 0;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const Eigen::Vector2d pixel((i + 0.5) / kGrid * width_px, (j + 0.5) / kGrid * height_px);
      auto ground = truth.GroundFromPixel(pixel, surface);
      if (!ground) {
        const auto ray =
            GroundRayFromPhoto(truth.camera, truth.pose, truth.photo_from_pixel * pixel);
        if (!ray) return std::nan("");
        const double drop = surface.MeanHeight() - ray->origin_m.z();
        ground = ray->origin_m + ray->direction * (drop / ray->direction.z());
      }
      const auto seen = other.PixelFromGround(*ground);
      if (!seen) return std::nan("");
      sum += (*seen - *truth.PixelFromGround(*ground)).squaredNorm();
    }
  return std::sqrt(sum / (kGrid * kGrid));
}

}  // namespace orient
