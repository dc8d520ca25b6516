// What `orient block` does with files: interior, exterior, neighbours, ties, adjustment, outputs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/files/adjustment_result.h"
#include "core/files/block_file.h"
#include "core/files/results.h"
#include "tools/block/quicklook.h"

namespace orient {

struct BlockRunOptions {
  BlockFile block;  // its camera is the path of a file
  bool resume = false;
  bool feedback = true;
  bool quicklook = false;
  int jobs = 0;
};

// The block adjustment in a few numbers.
struct BlockSummary {
  int photos = 0, by_neighbours = 0;  // that took part; of these without patches of their own
  int ties = 0, sightings = 0, rejected = 0;
  std::optional<double> tie_sigma0_px, check_rms_px;
  int checks = 0;
};

struct BlockRunResult {
  std::vector<ExteriorResult> results;  // final, as the block's photos
  // Absent where there was nothing to adjust:
  std::optional<AdjustmentResult> adjusted;
  std::optional<BlockSummary> summary;
  std::optional<Quicklook> quicklook;
  // Photos that a table of approximations names and that are not there: a scan may be missing. A
  // flight index shows the whole flight, of which a block may be a part.
  std::vector<std::string> not_there;
  std::vector<std::string> messages;
};

// Whether a run into this folder was interrupted before its end.
bool IsUnfinished(const std::string& output_directory);

// Runs all stages; see docs/block.md for what is written. Without `resume` what earlier runs left
// is done again, with it all that is there and made from the same inputs is kept. Throws InputError
// for what concerns all photos.
BlockRunResult RunBlock(const BlockRunOptions& options);

// What would be done, one line a photo and stage: "do" or "keep".
std::vector<std::string> PlanBlock(const BlockRunOptions& options);

}  // namespace orient
