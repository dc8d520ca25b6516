// The geometry of a camera as its calibration report gives it. Photo system: mm, x right, y up.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/geometry/lens.h"
#include "core/geometry/transform2d.h"

namespace orient {

enum class CameraKind { kFilm, kDigital };

struct Camera {
  std::string name;
  CameraKind kind = CameraKind::kFilm;
  double principal_distance_mm = 0;
  Eigen::Vector2d principal_point_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d frame_mm = Eigen::Vector2d::Zero();         // exposed area; digital: the sensor
  Eigen::Vector2d frame_centre_mm = Eigen::Vector2d::Zero();  // in the photo system
  std::optional<Eigen::Vector2i> image_px;                    // digital only: width, height
  LensDistortion lens;
  // Part of the lens's k1 due to curvature and refraction (earth_effects.h), per mm^2; 0: none.
  double earth_k1 = 0;

  // Half the frame's diagonal, mm: no image point lies farther from the frame's centre.
  double FrameRadius() const { return 0.5 * frame_mm.norm(); }
  bool InFrame(const Eigen::Vector2d& photo_mm, double margin_mm = 0) const;
};

// A digital camera's fixed transform: x = (col - width/2) p, y = (height/2 - row) p.
// Throws std::invalid_argument for a film camera.
Affine2d DigitalPhotoFromPixel(const Camera& camera);

}  // namespace orient
