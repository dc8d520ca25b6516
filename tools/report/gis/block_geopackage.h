// block.gpkg: the block for a GIS.
#pragma once

#include <string>
#include <vector>

#include "core/files/adjustment_result.h"
#include "core/files/results.h"
#include "core/terrain/crs.h"

namespace orient {

// A photo without an exterior result: it failed before, or its file is lost or damaged.
struct PhotoWithoutResult {
  std::string name;
  Status status = Status::kFailed;
  std::string message;
};

// Writes directory/block.gpkg whole or not at all and returns its path. Layers, in `crs`, each with
// its spatial index:
//   photos      PointZ: projection centres; a photo without a pose, or without a result, has no
//               geometry; `picture` names the file beside, if there is one
//   footprints  Polygon: the frames' outlines on the ground
//   patches     PointZ: every patch once for each photo that looked for it and could see it
//   residuals   LineString: residuals of matched and rejected patches and of ties on the ground,
//               from the point into the direction measured - computed, exaggerated by the column
//               `exaggeration`; `kind` says whether `patch` is the id of a patch or of a tie
//   ties        PointZ: every tie point of the block adjustment, where there was one
// and `layer_styles`, which QGIS reads by itself. The file's metadata name program version and
// inputs as run.json does.
// Angles are in degrees, lengths in m, residuals in px. Columns
// without a value are NULL. Throws InputError naming the file where it cannot be written.
std::string WriteBlockGeopackage(const std::string& directory, const Crs& crs,
                                 const std::vector<ExteriorResult>& results,
                                 const AdjustmentResult* adjusted = nullptr,
                                 const std::vector<PhotoWithoutResult>& others = {});

}  // namespace orient
