// One interest point made into a patch, or refused.
#pragma once

#include <variant>

#include "core/raster/colour_raster.h"
#include "patchdb/harvest/candidates.h"
#include "patchdb/harvest/harvest_options.h"

namespace orient::patchdb {

// Bits of a chip's values, 8 or 16. Throws InputError for values that these do not hold.
int StoredBits(const Raster& raster);

// What is the same for all patches of a source; nothing is owned.
struct PatchMaker {
  const Raster& raster;
  const SourceView& source;
  const GroundSurface& surface;
  const HarvestOptions& options;
  const HarvestContext& context;
  int bits = 8;
  double dem_sigma_m = 0;
  const ColourRaster* colour = nullptr;  // absent: grey chips

  // The source shows this place better than all further ones.
  bool ShowsBest(const Eigen::Vector3d& ground_m) const;

  // Safe to call from several threads. Cheap tests come first.
  std::variant<Patch, Refusal> Make(const InterestCandidate& candidate) const;
};

}  // namespace orient::patchdb
