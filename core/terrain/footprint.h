// Where an oriented photo's frame lies on the ground.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient {

// The frame's outline as a closed ring; rays that miss the DEM end at its mean height. Empty if
// part of the frame looks at the horizon.
std::vector<Eigen::Vector3d> Footprint(const PhotoView& view, const GroundSurface& surface);

}  // namespace orient
