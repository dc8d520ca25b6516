// `orient block` on image measurements alone.
#pragma once

#include <iosfwd>

#include "core/files/block_file.h"
#include "tools/commands/commands.h"

namespace orient {

// Adjusts what the block's folder of measurements holds; writes the photos' results,
// orientation.csv, block.json and control_points.csv. Throws UsageError where one of them is there
// already and `overwrite` is not given.
ExitCode AdjustMeasuredBlock(const BlockFile& block, bool overwrite, std::ostream& out);

}  // namespace orient
