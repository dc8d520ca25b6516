// The report's part about the block as a whole.
#pragma once

#include <string>

#include "tools/report/verdict.h"

namespace orient {

// What the adjustment says: precision, reliability, check patches, parts, calibration. Empty where
// the folder has no block.json.
std::string AdjustmentSection(const BlockRecord& block);

// How the film of all photos lies against its calibrated marks. Empty without film.
std::string FilmSection(const BlockRecord& block);

}  // namespace orient
