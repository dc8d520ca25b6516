// Which photos of a block are connected, and whether each connected part has a datum. Private to
// block.
#pragma once

#include <vector>

#include "block/bundle/equations.h"

namespace orient::block {

// By the observations that connect (all of them are as many as the block's); `takes_part` of each
// photo. Every photo is in one part. Fills photos, control_points,
// has_datum, by_control and finding.
std::vector<BlockPart> FindParts(const BlockSystem& system, const std::vector<bool>& connects,
                                 const std::vector<bool>& takes_part);

// "a, b, c and 12 more"
std::string NamesOf(const BlockToAdjust& block, const std::vector<std::size_t>& photos);

}  // namespace orient::block
