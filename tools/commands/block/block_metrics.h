// How far a block is, for a monitor.
#pragma once

#include <string>
#include <vector>

#include "block/part.h"

namespace orient {

// Prometheus's text format, as its node exporter reads it from a file: orient_photos{stage,state},
// orient_photos_per_hour{stage} where it is known, orient_block_finished.
std::string MetricsText(const std::vector<block::StageStatus>& stages, bool finished);

// Writes it to a file, replacing an earlier such text. Throws UsageError where the file is another.
void WriteMetrics(const std::string& path, const std::vector<block::StageStatus>& stages,
                  bool finished);

}  // namespace orient
