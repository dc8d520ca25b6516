// What lies under a click on a fiducial mark, measured at once.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"

namespace orient {

struct SeenAtClick {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // of the scan
  double correlation = 0;                           // of the mark's drawing and the scan there
};

// Where the mark's drawing fits best within 6 px of the click; size, orientation and polarity are
// those that `interior` knows, otherwise the resolution tag's, upright and positive. A preview: the
// run measures the mark anew, beside all others. Empty where the camera has no such mark or draws
// it as a picture, or nothing tells the pixel size. Throws InputError where the scan is damaged.
std::optional<SeenAtClick> SeeMark(const Raster& scan, const CameraFile& camera,
                                   const InteriorResult* interior, const std::string& mark,
                                   const Eigen::Vector2d& click);

}  // namespace orient
