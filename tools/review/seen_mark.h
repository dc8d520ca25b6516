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

// What is known of how a scan shows the film; what a person says comes first.
struct ScanKnowledge {
  std::optional<double> pixel_size_um;  // otherwise the resolution tag's
  std::optional<Polarity> polarity;
  std::optional<ScanOrientation> orientation;
  std::optional<Affine2d> photo_from_pixel;  // stands for size and orientation
};

// Where the mark's drawing fits best within 6 px of the click, in any polarity and orientation that
// is not known. A preview: the run measures the mark anew, beside all others. Empty where the
// camera has no such mark or draws it as a picture, where nothing tells the pixel size, and where
// there is nothing to compare. Throws InputError where the scan is damaged.
std::optional<SeenAtClick> SeeMark(const Raster& scan, const CameraFile& camera,
                                   const ScanKnowledge& known, const std::string& mark,
                                   const Eigen::Vector2d& click);

}  // namespace orient
