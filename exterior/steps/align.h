// Step 2, align: a patch drawn as the new photo should see it under the current pose.
//
// Every pixel of the drawing is followed along its ray to the heights that the patch carries and
// takes its grey value from the chip there: scale, rotation, tilt and relief at once.
#pragma once

#include <optional>

#include "core/raster/image.h"
#include "core/terrain/photo_view.h"
#include "patchdb/store/patch.h"

namespace orient::exterior {

struct AlignedPatch {
  Image image;                   // square, odd side; its centre shows the patch's ground point
  double reduction = 1;          // scan pixels per image pixel
  Eigen::Vector2d predicted_px;  // scan pixel of the ground point under the pose

  Eigen::Vector2d Centre() const { return {image.width / 2.0, image.height / 2.0}; }
};

// Side of the largest square that the chip covers, in scan pixels. Empty where the point is not
// seen.
std::optional<double> PatchSide(const PhotoView& view, const patchdb::Patch& patch);

// Side of one of the chip's pixels in scan pixels, where the patch lies. Empty where the point is
// not seen.
std::optional<double> PatchPixel(const PhotoView& view, const patchdb::Patch& patch);

// The largest square that the chip covers, at `reduction` scan pixels per pixel, but at most
// `max_side` pixels. Chips finer than the photo are area-averaged, coarser ones interpolated. Empty
// where the point is not seen or the square would be smaller than `min_side`.
std::optional<AlignedPatch> AlignPatch(const PhotoView& view, const patchdb::Patch& patch,
                                       double reduction, int min_side, int max_side);

}  // namespace orient::exterior
