// An adjusted block in a few numbers.
#pragma once

#include <optional>
#include <vector>

#include "block/inputs/block_photos.h"
#include "core/files/adjustment_result.h"

namespace orient::block {

struct BlockSummary {
  int photos = 0, by_neighbours = 0;  // that took part; of these without patches of their own
  int ties = 0, sightings = 0, rejected = 0;
  std::optional<double> tie_sigma0_px, check_rms_px;
  int checks = 0;
};

BlockSummary Summarize(const AdjustmentResult& adjusted, const std::vector<BlockPhotoFile>& photos);

}  // namespace orient::block
