// How a ground point's place in a scan moves with the photo's pose and with the ground point: the
// collinearity equations linearised in scan pixels.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/terrain/photo_view.h"

namespace orient {

struct PixelDerivatives {
  Eigen::Vector2d photo_mm;               // where it is in the photo system
  Eigen::Matrix<double, 2, 6> by_pose;    // px per m, px per rad
  Eigen::Matrix<double, 2, 3> by_ground;  // px per m
  Eigen::Vector2d by_principal_distance;  // px per mm
};

// Empty as PhotoFromGroundWithDerivatives. The film's local correction is taken for constant.
std::optional<PixelDerivatives> PixelFromGroundWithDerivatives(const PhotoView& view,
                                                               const Eigen::Vector3d& ground_m);

}  // namespace orient
