// Blocks too large for one adjustment: overlapping sub-blocks, each adjusted by itself, and joined.
//
// Each photo's pose is that of the sub-block in whose core it lies; the photos around a core, which
// share points with it or with such photos, are adjusted with it and belong to other cores. What
// lies farther away is left out: with control all over the block it says next to nothing of a pose.
#pragma once

#include <vector>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"
#include "block/bundle/joined_sub_blocks.h"

namespace orient::block {

// Halves the block across its longer side until no sub-block has more than `most_photos`, or its
// halves would hardly be smaller (with few photos, most are around the core). Throws
// std::invalid_argument for indices out of range.
std::vector<SubBlock> DivideBlock(const BlockToAdjust& block, std::size_t most_photos);

// AdjustBlock, in sub-blocks where the block has more photos than BlockOptions::most_photos. Then
// the covariances of poses are each sub-block's own (none of all poses together), and
// BlockResult::sub_blocks says how well these agree. Throws std::invalid_argument as AdjustBlock
// does, and for self-calibration in sub-blocks, which would give each a camera of its own.
BlockResult AdjustWholeOrInSubBlocks(const BlockToAdjust& block, const BlockOptions& options);

}  // namespace orient::block
