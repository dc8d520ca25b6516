#include "tools/commands/block/block_metrics.h"

#include <fmt/format.h>

namespace orient {
namespace {

std::string Head(const char* name, const char* help) {
  return fmt::format("# HELP {0} {1}\n# TYPE {0} gauge\n", name, help);
}

}  // namespace

std::string MetricsText(const std::vector<block::StageStatus>& stages, bool finished) {
  std::string text = Head("orient_photos", "Photos of the block, by stage and state.");
  for (const block::StageStatus& status : stages)
    for (const auto& [state, count] : {std::pair("ok", status.ok),
                                       {"weak", status.weak},
                                       {"failed", status.failed},
                                       {"unreadable", status.unreadable},
                                       {"left", status.Left()}})
      text += fmt::format("orient_photos{{stage=\"{}\",state=\"{}\"}} {}\n",
                          block::Name(status.stage), state, count);
  text += Head("orient_photos_per_hour", "Results of the last hour, all machines together.");
  for (const block::StageStatus& status : stages)
    if (status.per_hour)
      text += fmt::format("orient_photos_per_hour{{stage=\"{}\"}} {:.1f}\n",
                          block::Name(status.stage), *status.per_hour);
  text += Head("orient_block_finished", "Whether all outputs of the block are written.");
  return text + fmt::format("orient_block_finished {}\n", finished ? 1 : 0);
}

}  // namespace orient
