// A mark's centre to a small fraction of a pixel: least-squares matching with the drawing.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/files/results.h"
#include "core/imaging/raster.h"
#include "interior/mark_drawing.h"

namespace orient {

struct MarkPosition {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // px^2
  double correlation = 0;    // of the drawing and the scan, positive for either polarity
  double blur_sigma_px = 0;  // of the scan, as it fits best
};

// `pixel_from_mm`: linear part of scan pixel from photo mm, turn and scale as found. The scanner's
// blur is found by trying several. Empty where nothing converges within `max_shift_px` of `start`.
std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Eigen::Matrix2d& pixel_from_mm,
                                        const Eigen::Vector2d& start, Polarity polarity,
                                        double max_shift_px);

}  // namespace orient
