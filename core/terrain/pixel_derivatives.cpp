#include "core/terrain/pixel_derivatives.h"

namespace orient {

std::optional<PixelDerivatives> PixelFromGroundWithDerivatives(const PhotoView& view,
                                                               const Eigen::Vector3d& ground_m) {
  const auto projection = PhotoFromGroundWithDerivatives(view.camera, view.pose, ground_m);
  if (!projection) return std::nullopt;
  const Eigen::Matrix2d pixel_from_photo = view.photo_from_pixel.Inverse().A;
  return PixelDerivatives{projection->photo_mm, pixel_from_photo * projection->by_pose,
                          pixel_from_photo * projection->by_ground,
                          pixel_from_photo * projection->by_principal_distance};
}

}  // namespace orient
