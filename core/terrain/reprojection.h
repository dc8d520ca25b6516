// How far apart two poses of one photo see the ground: the measure by which orientations are
// judged.
#pragma once

#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"

namespace orient {

// RMS over a 20 x 20 grid of ground points across the whole frame of the distance, in pixels,
// between their projections under `truth` and under `pose`. Where the DEM has no height its mean
// height serves.
double ReprojectionRms(const PhotoView& truth, const Pose& pose, int width_px, int height_px,
                       const GroundSurface& surface);

}  // namespace orient
