// One picture of many orthophotos.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "core/terrain/crs.h"
#include "ortho/map_grid.h"
#include "ortho/mosaic_part.h"
#include "ortho/seamlines.h"

namespace orient::ortho {

// Writes `path`: at each pixel the orthophoto whose seamline polygon it lies in, and where that
// shows nothing (hidden ground, the end of the photo) or there is no polygon, the one with the
// nearest nadir that shows it. Pixels are copied, except for their parts' tones (rounded, and as
// far as the format's values go). Works in tiles on all cores: memory does not grow with the
// mosaic. `listener` may be null. Throws InputError: no part, parts of different bands, bits or
// pixel sizes, a damaged one, a seamline of a photo that is no part.
MapGrid MakeMosaic(const std::vector<MosaicPart>& parts, const Seamlines& seamlines, const Crs& crs,
                   const std::map<std::string, std::string>& metadata, int threads,
                   const std::string& path, ProgressListener* listener);

}  // namespace orient::ortho
