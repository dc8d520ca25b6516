#include "block/verdict/block_summary.h"

#include "block/bundle/bundle_result.h"

namespace orient::block {

BlockSummary Summarize(const AdjustmentResult& adjusted,
                       const std::vector<BlockPhotoFile>& photos) {
  BlockSummary summary;
  for (const PartResult& part : adjusted.parts)
    summary.photos += static_cast<int>(part.photos.size());
  for (const BlockPhotoFile& photo : photos) summary.by_neighbours += photo.by_neighbours;
  summary.ties = static_cast<int>(adjusted.ties.size());
  for (const PointResult& tie : adjusted.ties)
    for (const SightingResult& sighting : tie.seen) {
      ++summary.sightings;
      summary.rejected += sighting.state == Name(ObservationState::kRejected);
    }
  for (const ComponentResult& component : adjusted.components)
    if (component.group == "tie image") summary.tie_sigma0_px = component.sigma0_px;
  summary.checks = static_cast<int>(adjusted.checks.size());
  summary.check_rms_px = adjusted.CheckRmsPx();
  return summary;
}

}  // namespace orient::block
