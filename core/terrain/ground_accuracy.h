// CE90: how well a place that a photo shows lies on the map. The one definition of it, for
// orthophotos and for the report.
#pragma once

#include <optional>

#include "core/geometry/pose.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient {

// The radius of the circle about its true place in which a point lies with a probability of 90 %,
// for normal errors of this covariance (m^2).
double CircularError90(const Eigen::Matrix2d& covariance);

// CE90 of places over the frame (7 x 7 of them, its border included): of a usual place, and where
// it is largest.
struct GroundAccuracy {
  double median_m = 0, worst_m = 0;
};

// Of points on the surface that the photo shows, by the covariance of its pose and by errors of the
// surface's heights (one sigma, m), which move a point away from the nadir. Empty where the frame
// shows no surface.
std::optional<GroundAccuracy> AccuracyOf(const PhotoView& view, const Matrix6d& covariance,
                                         const GroundSurface& surface, double height_sigma_m);

}  // namespace orient
