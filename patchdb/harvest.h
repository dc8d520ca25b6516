// Patches cut from what is already oriented: a photo with its orientation, or an orthophoto, and a
// DEM. Interest points (Foerstner) are spread over the ground by a grid with one patch a cell; what
// is repetitive, flat, short-lived or without heights is refused, and counted by reason.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/ground_surface.h"
#include "core/geometry/photo_view.h"
#include "core/imaging/raster.h"
#include "patchdb/patch.h"

namespace orient {

enum class Refusal {
  kNoHeight,    // the DEM does not cover the chip
  kNoImage,     // the chip reaches beyond the image or into nodata
  kRelief,      // the ground under the chip is too rugged
  kFlat,        // hardly any contrast
  kRepetitive,  // fits at a second place nearby
  kShortLived   // lost on the first pyramid levels
};
inline constexpr std::array<Refusal, 6> kAllRefusals = {Refusal::kNoHeight,   Refusal::kNoImage,
                                                        Refusal::kRelief,     Refusal::kFlat,
                                                        Refusal::kRepetitive, Refusal::kShortLived};
std::string_view Name(Refusal refusal);  // "no height", ...

struct HarvestOptions {
  int chip_px = 61;                  // odd; side of a chip
  std::optional<double> spacing_px;  // side of a grid cell in source pixels; empty: from max_count
  int max_count = 800;               // cells a source, where spacing_px is empty
  double min_spacing_px = 30;        // where spacing_px is empty: half a chip
  int tries_per_cell = 4;            // candidates looked at, strongest first
  double min_contrast = 2;           // standard deviation, in levels of 8 bit of the value range
  double min_distinctness = 0.2;
  int min_persistence = 2;
  double max_relief_px = 60;          // height spread in chip pixels: about 45 degrees of slope
  double orientation_sigma_px = 0.5;  // of the source, where its own covariance is not known
  double pointing_sigma_px = 0.1;     // of an interest point
  std::optional<double> dem_sigma_m;  // empty: a tenth of the DEM's cell
  int tile_px = 512;                  // interest points are sought tile by tile
  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

struct HarvestResult {
  double gsd_m = 0;            // median over the source
  int candidates = 0;          // interest points on known ground
  int cells = 0;               // grid cells with at least one candidate
  std::vector<Patch> patches;  // in order of their cells: north to south, west to east
  std::array<int, kAllRefusals.size()> refused = {};
  int Refused(Refusal refusal) const { return refused[static_cast<std::size_t>(refusal)]; }
};

// Told of every step: the stage ("searching tiles", then "cutting patches"), steps done and in all.
using HarvestProgress = std::function<void(std::string_view stage, int done, int total)>;

// `photo` is the raster that `view` orients; ground coordinates are those of view.pose and surface.
// `pose_covariance` in the order of Pose::AsVector. Throws InputError: the surface does not cover
// the photo, a raster of more than 16 bits; std::invalid_argument: options that Check() refuses.
HarvestResult HarvestPhoto(const Raster& photo, const PhotoView& view,
                           const std::optional<Matrix6d>& pose_covariance,
                           const GroundSurface& surface, const HarvestOptions& options = {},
                           const HarvestProgress& progress = {});

// `surface` and the patches are in ground_crs; the orthophoto is transformed where its own differs.
// Throws like HarvestPhoto, and InputError for an orthophoto without georeference or CRS.
HarvestResult HarvestOrtho(const Raster& ortho, const Crs& ground_crs, const GroundSurface& surface,
                           const HarvestOptions& options = {},
                           const HarvestProgress& progress = {});

// An orthophoto may be as large as a county: more patches in all, at the same distance.
HarvestOptions OrthoHarvestOptions();

}  // namespace orient
