// Patches cut from what is already oriented: a photo with its orientation, or an orthophoto, and a
// DEM. Interest points (Foerstner) are spread over the ground by a grid with one patch a cell; what
// is repetitive, flat, short-lived, without heights or contradicted by other sources is refused,
// and counted by reason.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "core/raster/raster.h"
#include "core/terrain/ground_surface.h"
#include "core/terrain/photo_view.h"
#include "patchdb/harvest/harvest_options.h"
#include "patchdb/store/patch.h"

namespace orient::patchdb {

struct HarvestResult {
  double gsd_m = 0;            // median over the source
  int candidates = 0;          // interest points on known ground
  int cells = 0;               // grid cells with at least one candidate
  std::vector<Patch> patches;  // in order of their cells: north to south, west to east
  std::array<int, kAllRefusals.size()> refused = {};
  int Refused(Refusal refusal) const { return refused[static_cast<std::size_t>(refusal)]; }
};

// Called at every step: the stage ("searching tiles", then "cutting patches"), steps done, in all.
using HarvestProgress = std::function<void(std::string_view stage, int done, int total)>;

// `photo` is the raster that `view` orients; ground coordinates are those of view.pose and surface.
// `pose_covariance` in the order of Pose::AsVector. Throws InputError: the surface does not cover
// the photo, a raster of more than 16 bits; std::invalid_argument: options that Check() refuses.
// The same patches whatever the number of threads.
HarvestResult HarvestPhoto(const Raster& photo, const PhotoView& view,
                           const std::optional<Matrix6d>& pose_covariance,
                           const GroundSurface& surface, const HarvestOptions& options = {},
                           const HarvestProgress& progress = {},
                           const HarvestContext& context = {});

// `surface` and the patches are in ground_crs; the orthophoto is transformed where its own differs.
// Throws like HarvestPhoto, and InputError for an orthophoto without georeference or CRS.
HarvestResult HarvestOrtho(const Raster& ortho, const Crs& ground_crs, const GroundSurface& surface,
                           const HarvestOptions& options = {}, const HarvestProgress& progress = {},
                           const HarvestContext& context = {});

// An orthophoto may be as large as a county: more patches in all, at the same distance.
HarvestOptions OrthoHarvestOptions();

}  // namespace orient::patchdb
