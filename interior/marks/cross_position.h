// A cross's centre from its arms alone (Jiang, Zhang & Li): a parabola across the profile, straight
// lines by least squares through the points on both strokes, and their intersection.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/files/camera_file.h"
#include "core/files/results.h"
#include "core/raster/raster.h"

namespace orient::interior {

struct MeasuredCross {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  // px^2
  // Of the stroke that shows less (StrokeEvidence).
  double share = 0;
  double nats = 0;
};

// `start`: within two pixels or so of the mark's centre, beside which the cross may lie (at_mm), as
// may the result; strokes drawn with a brightness of 0 or less are dark on a positive.
// `pixel_from_mm`: linear part of scan pixel from
// photo mm, rotation and scale as found.
//
// The profile is taken down the columns (along the rows for the steeper stroke), one for every
// pixel along the stroke, so that no grey value is interpolated. With g1 and g2 its first and half
// its second derivative, smoothed by a Gaussian as wide as the stroke, at the line as it is known,
// t = -g1 / (2 g2) leads to the top. Lines go through these points with weights g2^2 (equal noise
// of the grey values), without points more than three sigmas off, and the profiles are taken anew
// at them until they stay.
//
// The covariance comes from what the points leave at the lines; neighbours on a line have
// correlated errors (grain through the blur, the picture's own edges), so their autocovariance
// enters. What undersampling may do to strokes of about two pixels or less enters as a systematic
// error.
//
// Empty where less than half of a stroke is seen, or nothing converges within `max_shift_px` of
// `start`.
std::optional<MeasuredCross> MeasureCross(const Raster& scan, const CrossElement& cross,
                                          const Eigen::Matrix2d& pixel_from_mm,
                                          const Eigen::Vector2d& start, Polarity polarity,
                                          double max_shift_px);

}  // namespace orient::interior
