// Inconspicuous seamlines.
#pragma once

#include <vector>

#include "ortho/mosaic_cells.h"
#include "ortho/seamlines.h"

namespace orient::ortho {

// As Seamlines::ByNearestNadir, but within a strip on both sides of its lines, a quarter of the
// distance of the two nadirs wide, each line runs where the two photos differ least: around houses
// that lean, shadows and cars, not through them. A pair's line is the least cut of a graph of the
// cells that both show (Kwatra et al. 2003), pair after pair. A constant difference of the two
// photos' tones counts nothing. `cells` are those of `photos`, in their order.
Seamlines SeamlinesOfLeastDifference(const std::vector<SeamPhoto>& photos,
                                     const std::vector<PhotoCells>& cells);

}  // namespace orient::ortho
