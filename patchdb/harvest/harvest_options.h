// What a harvest may be asked for, what it refuses and why, and what else it may look at.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/chi_square.h"
#include "core/terrain/ground_surface.h"
#include "patchdb/harvest/further_views.h"

namespace orient::patchdb {

enum class Refusal {
  kNoHeight,      // the DEM does not cover the chip
  kNoImage,       // the chip reaches beyond the image or into nodata
  kRelief,        // the ground under the chip is too rugged
  kFlat,          // hardly any contrast
  kRepetitive,    // fits at a second place nearby
  kShortLived,    // lost on the first pyramid levels
  kNotConfirmed,  // other sources show the place, but most of them not this texture
  kDisagreement,  // they show it where no one point can lie
  kOtherHeight,   // they intersect at another height than the DEM's: a roof, a crown, a wrong DEM
  kStanding       // the surface model has something standing there
};
inline constexpr std::array<Refusal, 10> kAllRefusals = {
    Refusal::kNoHeight,    Refusal::kNoImage,    Refusal::kRelief,       Refusal::kFlat,
    Refusal::kRepetitive,  Refusal::kShortLived, Refusal::kNotConfirmed, Refusal::kDisagreement,
    Refusal::kOtherHeight, Refusal::kStanding};
std::string_view Name(Refusal refusal);  // "no height", ...

struct HarvestOptions {
  int chip_px = 61;                  // odd; side of a chip
  std::optional<double> spacing_px;  // side of a grid cell in source pixels; empty: from max_count
  int max_count = 800;               // cells per source, where spacing_px is empty
  double min_distinctness = 0.2;
  int min_persistence = 2;
  double max_lean_px = 4;             // of what stands in the surface model
  double orientation_sigma_px = 0.5;  // of the source, where its own covariance is not known
  std::optional<double> dem_sigma_m;  // empty: a tenth of the DEM's cell
  int max_further_views = 4;          // other sources a patch is searched for in, the best ones
  bool colour = false;                // chips in colour, where the source has some
  int tile_px = 512;                  // interest points are searched for tile by tile
  std::optional<std::string> Check() const;  // what is wrong with the options, if anything
};

// What a harvest may look at besides its source; nothing of it is owned.
struct HarvestContext {
  // Of one place the source that shows it best is harvested (ViewingPenalty; of equals that of the
  // least number), the others give evidence: PatchEvidence::source_id is FurtherSource::number.
  std::vector<FurtherSource> further;
  int number = 0;                        // of the source itself
  std::vector<Eigen::Vector2d> taken_m;  // places that have a patch already
  const GroundSurface* dsm = nullptr;    // heights with everything that stands there
};

}  // namespace orient::patchdb
