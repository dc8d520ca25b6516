// One candidate made into a patch: heights from the surface, grey values from the source, the
// ground point's covariance.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/raster/colour_raster.h"
#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/harvest/source_view.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

// Heights around a point, over at least half_width_m in every direction; nodes at half the
// surface's cells, but no denser than min_step_m. NaN where the surface has no height.
HeightGrid CutHeights(const GroundSurface& surface, const Eigen::Vector2d& centre_m,
                      double half_width_m, double min_step_m);

// Highest minus lowest node; NaN where one is unknown.
double HeightSpread(const HeightGrid& heights);

// The chip, north up, its middle at ground_m: every pixel's own height goes through the source's
// geometry, the grey value is interpolated (bicubic). NaN: no data in the source. Empty where part
// of the ground is not seen at all, or the piece of the source would be absurdly large.
std::optional<Image> RectifyChip(const Raster& raster, const SourceView& source,
                                 const HeightGrid& heights, const Eigen::Vector3d& ground_m,
                                 int chip_px, double gsd_m);

// Chips are stored without a sign. Throws InputError where the source has values below 0 under this
// one.
void RequireNoSign(const Image& chip, const Raster& raster, const SourceView& source,
                   const HeightGrid& heights, const Eigen::Vector3d& ground_m, double gsd_m);

// Share of the same chip's pixels that lie in voids which the source does not declare
// (undeclared_void.h).
double VoidShare(const Raster& raster, const SourceView& source, const HeightGrid& heights,
                 const Eigen::Vector3d& ground_m, int chip_px, double gsd_m);

// Red, green and blue of the same chip; not empty where RectifyChip is not.
std::vector<Image> RectifyColour(const ColourRaster& colour, const Raster& raster,
                                 const SourceView& source, const HeightGrid& heights,
                                 const Eigen::Vector3d& ground_m, int chip_px, double gsd_m);

// How far another surface (roofs, crowns: a DSM) departs from the heights that a chip carries, in
// chip pixels of lean at 45 degrees: the largest departure near the chip's middle, or the one that
// three quarters of the chip stay below, whichever is larger. Around the middle a photo's lines of
// sight are followed: what they meet on their way down departs, too. Empty where the other surface
// knows less than three quarters of the chip, or nothing of its middle.
std::optional<double> LeanOf(const GroundSurface& surface, const SourceView& source,
                             const Patch& patch);

}  // namespace orient::patchdb
