// What block.json, the report and block.gpkg say of an adjusted block.
#pragma once

#include "block/stages/adjustment_stage.h"
#include "core/files/adjustment_result.h"

namespace orient::block {

// `findings`: of all stages, the adjustment's own among them.
AdjustmentResult SummaryOf(const AdjustedBlock& adjusted, const Findings& findings);

}  // namespace orient::block
