// The report's part about the block as a whole.
#pragma once

#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

// What the adjustment says: precision, reliability, check patches, parts, calibration. Empty where
// the folder has no block.json.
Markup AdjustmentSection(const BlockRecord& block);

}  // namespace orient
