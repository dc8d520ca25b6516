#include "tools/commands/block/block_metrics.h"

#include <fmt/format.h>

#include <filesystem>
#include <string_view>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"

namespace orient {
namespace {

constexpr std::string_view kBegin = "# HELP orient_";

std::string Head(const char* name, const char* help) {
  return fmt::format("{0}{1} {2}\n# TYPE orient_{1} gauge\n", kBegin, name, help);
}

}  // namespace

std::string MetricsText(const std::vector<block::StageStatus>& stages, bool finished) {
  std::string text = Head("photos", "Photos of the block, by stage and state.");
  for (const block::StageStatus& status : stages)
    for (const auto& [state, count] : {std::pair("ok", status.ok),
                                       {"weak", status.weak},
                                       {"failed", status.failed},
                                       {"unreadable", status.unreadable},
                                       {"left", status.Left()}})
      text += fmt::format("orient_photos{{stage=\"{}\",state=\"{}\"}} {}\n",
                          block::Name(status.stage), state, count);
  text += Head("photos_per_hour", "Results of the last hour, all machines together.");
  for (const block::StageStatus& status : stages)
    if (status.per_hour)
      text += fmt::format("orient_photos_per_hour{{stage=\"{}\"}} {:.1f}\n",
                          block::Name(status.stage), *status.per_hour);
  text += Head("block_finished", "Whether all outputs of the block are written.");
  return text + fmt::format("orient_block_finished {}\n", finished ? 1 : 0);
}

void WriteMetrics(const std::string& path, const std::vector<block::StageStatus>& stages,
                  bool finished) {
  if (std::filesystem::exists(path)) {
    RequireNoPipe(path);
    if (const std::string there = ReadFile(path); !there.empty() && !there.starts_with(kBegin))
      throw UsageError(path + " exists and holds no metrics of orient; choose another file");
  }
  WriteFileAtomically(path, MetricsText(stages, finished));
}

}  // namespace orient
