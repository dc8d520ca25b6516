// What block.json, the report and block.gpkg say of an adjusted block.
#pragma once

#include <string>
#include <vector>

#include "block/stages/adjustment_stage.h"
#include "core/files/adjustment_result.h"

namespace orient::block {

// `messages`: of all stages, the adjustment's own among them.
AdjustmentResult SummaryOf(const AdjustedBlock& adjusted, const std::vector<std::string>& messages);

}  // namespace orient::block
