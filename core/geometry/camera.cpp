#include "core/geometry/camera.h"

#include <cmath>
#include <stdexcept>

namespace orient {

bool Camera::InFrame(const Eigen::Vector2d& photo_mm, double margin_mm) const {
  const Eigen::Vector2d offset = (photo_mm - frame_centre_mm).cwiseAbs();
  return offset.x() <= 0.5 * frame_mm.x() + margin_mm &&
         offset.y() <= 0.5 * frame_mm.y() + margin_mm;
}

Affine2d DigitalPhotoFromPixel(const Camera& camera) {
  if (camera.kind != CameraKind::kDigital || !camera.image_px)
    throw std::invalid_argument("camera '" + camera.name +
                                "' is not a digital camera with a known image size");
  const Eigen::Vector2d size = camera.image_px->cast<double>();
  if (!(size.minCoeff() > 0) || !(camera.frame_mm.minCoeff() > 0))
    throw std::invalid_argument("camera '" + camera.name + "' has an empty image or sensor");
  Affine2d photo_from_pixel;
  photo_from_pixel.A = Eigen::Vector2d(camera.frame_mm.x() / size.x(),  //
                                       -camera.frame_mm.y() / size.y())
                           .asDiagonal();
  photo_from_pixel.t = -(photo_from_pixel.A * (0.5 * size));
  return photo_from_pixel;
}

}  // namespace orient
