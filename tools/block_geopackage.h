// block.gpkg: the block for a GIS.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"
#include "core/geometry/crs.h"

namespace orient {

// Writes directory/block.gpkg whole or not at all and returns its path. Layers, in `crs`, each with
// its spatial index:
//   photos      PointZ: projection centres; a photo without a pose has no geometry
//   footprints  Polygon: the frames' outlines on the ground
//   patches     PointZ: every patch once for each photo that looked for it
//   residuals   LineString: matched and rejected patches' residuals on the ground, from the patch
//               into the direction measured - computed, exaggerated by the column `exaggeration`
// Angles are in degrees, lengths in m, residuals in px. Columns without a value are NULL. Throws
// InputError naming the file where it cannot be written.
std::string WriteBlockGeopackage(const std::string& directory, const Crs& crs,
                                 const std::vector<ExteriorResult>& results);

}  // namespace orient
