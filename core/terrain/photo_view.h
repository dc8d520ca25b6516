// One oriented photo as a map between ground and scan: camera, film transform and pose together.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>

#include "core/geometry/bounds.h"
#include "core/geometry/camera.h"
#include "core/geometry/collinearity.h"
#include "core/geometry/film_correction.h"
#include "core/geometry/pose.h"
#include "core/geometry/transform2d.h"

namespace orient {

// Ground heights that a photo may be expected to show: the Dead Sea to the Himalaya.
constexpr double kLowestGround_m = -500, kHighestGround_m = 9000;

class GroundSurface;

struct PhotoView {
  Camera camera;
  Affine2d photo_from_pixel;
  Pose pose;
  // What the affine transform leaves of the film's deformation, where a reseau showed it.
  std::shared_ptr<const FilmCorrection> film_correction = nullptr;

  // Between scan and photo system, the film's correction included.
  Eigen::Vector2d PhotoFromPixel(const Eigen::Vector2d& pixel) const {
    return orient::PhotoFromPixel(photo_from_pixel, film_correction.get(), pixel);
  }
  Eigen::Vector2d PixelFromPhoto(const Eigen::Vector2d& photo_mm) const {
    return orient::PixelFromPhoto(photo_from_pixel, film_correction.get(), photo_mm);
  }
  // Scan pixel (col, row); empty behind the camera. May lie outside the scan or the frame.
  std::optional<Eigen::Vector2d> PixelFromGround(const Eigen::Vector3d& ground_m) const;
  // Where the pixel's ray meets the surface; empty where it does not.
  std::optional<Eigen::Vector3d> GroundFromPixel(const Eigen::Vector2d& pixel,
                                                 const GroundSurface& surface) const;
  // Mean pixel size in the photo system, mm.
  double PixelSize() const;
  // Ground sample distance of a vertical photo on level ground at this height, metres.
  double GroundPixel(double height_m) const;
};

// What of the ground the camera's frame can show when all heights lie in [min_height_m,
// max_height_m]: the rays of points along the frame's border, down to both heights. Empty where one
// of them points above the horizon or the whole camera lies below the ground.
std::optional<Bounds> FootprintBounds(const Camera& camera, const Pose& pose, double min_height_m,
                                      double max_height_m);

}  // namespace orient
