// How well an orthophoto's pixels lie on the map.
#pragma once

#include <optional>

#include "core/geometry/pose.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient::ortho {

// The radius of the circle about its true place in which a point lies with a probability of 90 %,
// for normal errors of this covariance (m^2).
double CircularError90(const Eigen::Matrix2d& covariance);

struct GroundAccuracy {
  double median_m = 0, worst_m = 0;  // CE90 over the frame
};

// Of points on the surface that the photo shows, by the covariance of its pose and by errors of the
// surface's heights (one sigma, m), which move a point away from the nadir. Empty where the frame
// shows no surface.
std::optional<GroundAccuracy> AccuracyOf(const PhotoView& view, const Matrix6d& covariance,
                                         const GroundSurface& surface, double height_sigma_m);

}  // namespace orient::ortho
