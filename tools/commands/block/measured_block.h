// `orient block` on image measurements alone.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "core/files/block_file.h"
#include "tools/commands/commands.h"
#include "tools/commands/record_run.h"

namespace orient {

struct MeasuredBlockRun {
  const Invocation& invoked;
  std::string block_path;
  bool resume = false;     // replace results: the adjustment is always made anew
  bool overwrite = false;  // the same, and discard what stages of photos left
  bool plan = false;       // only tell what would be done
};

// Adjusts what the block's folder of measurements holds; writes what a block of photos writes, but
// for what is drawn from scans. Throws UsageError where one of these files is there already and not
// to be replaced.
ExitCode AdjustMeasuredBlock(const BlockFile& block, const MeasuredBlockRun& run,
                             std::ostream& out);

}  // namespace orient
