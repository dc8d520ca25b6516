// The results of overlapping sub-blocks as one block's. Private to block.
#pragma once

#include <algorithm>
#include <vector>

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"

namespace orient::block {

struct SubBlock {
  std::vector<std::size_t> core;    // photos, ascending; every photo is in one core
  std::vector<std::size_t> beside;  // photos that share points with the core's, ascending
  std::vector<std::size_t> photos;  // the core and those around it, ascending

  bool IsInCore(std::size_t photo) const {
    return std::binary_search(core.begin(), core.end(), photo);
  }
};

struct AdjustedSubBlock {
  SubBlock sub;
  std::vector<std::size_t> points, observations;  // of the result: indices into the whole's
  BlockResult result;                             // its photos are sub.photos
};

// Poses are those of the sub-block in whose core the photo is; a point and all of its observations
// those of one sub-block in whose core a photo is that shows it. What is about the block as a whole
// (variance components, redundancy) is the mean or sum, each sub-block counted by the share of its
// observations that are taken from it.
BlockResult JoinSubBlocks(const BlockToAdjust& block, const BlockOptions& options,
                          const std::vector<AdjustedSubBlock>& adjusted);

}  // namespace orient::block
