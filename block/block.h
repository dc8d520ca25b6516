// A block oriented from its files: interior orientation, exterior orientation, neighbours, ties,
// adjustment.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "block/block_folder.h"
#include "block/block_inputs.h"
#include "block/inputs/block_photos.h"
#include "block/verdict/block_summary.h"
#include "core/base/progress.h"
#include "core/files/adjustment_result.h"
#include "core/files/camera_file.h"
#include "core/files/results.h"

namespace orient::block {

struct OrientedBlock {
  std::vector<ExteriorResult> results;  // final: of the block's photos, then of unusable ones
  std::vector<BlockPhotoFile> photos;   // as the stages left them, in the block's order
  CameraFile camera;                    // with which the final poses are valid
  // Absent where there was nothing to adjust:
  std::optional<AdjustmentResult> adjusted;
  std::optional<BlockSummary> summary;
  std::vector<std::string> control_points;  // lines of text about surveyed points
  // Photos that a table of approximations or of GNSS positions names and that are not there: a scan
  // may be missing.
  std::vector<std::string> not_there;
  Findings findings;  // what a person should know about the block as a whole
};

// Runs all stages in `folder`; see docs/block.md for what they leave there. What is there already
// and made from the same inputs is kept. `listener` may be null. Throws InputError for what
// concerns all photos.
OrientedBlock Orient(const BlockInputs& inputs, const BlockFolder& folder,
                     ProgressListener* listener = nullptr);

}  // namespace orient::block
