// The ground that a photo does not show: behind the camera, outside the frame, under a
// mark or writing, or behind a mountain. Patches there are not searched for.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/files/reason.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient::exterior {

// A rectangle of the photo system, mm, that shows something other than ground: a fiducial mark, or
// a clock, a counter and other writing within the frame.
struct CoveredArea {
  Eigen::Vector2d from_mm, to_mm;  // least x and y, largest x and y
};

enum class Unseen { kBehindCamera, kOutsidePhoto, kCovered, kHidden };

Reason ReasonOf(Unseen why);

// Whether the ground between a point and the projection centre rises above the ray that joins them.
// The heights are the surface's only, the point's too: a patch of another height datum is not
// hidden by that. Errs on the side of visible: the surface may be wrong by a quarter of its cell
// and 2 m, the projection centre by three sigma; where the surface has no heights nothing hides.
bool HiddenByTerrain(const GroundSurface& surface, const Eigen::Vector3d& projection_centre_m,
                     const Eigen::Matrix3d& centre_covariance_m2, const Eigen::Vector3d& ground_m);

}  // namespace orient::exterior
