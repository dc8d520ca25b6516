// Patches as lines of CSV; an empty cell is unknown.
#pragma once

#include <ostream>
#include <string>

#include "patchdb/selection.h"

namespace orient {

// Both without the line's end, so that a verb may add columns.
void PrintSummaryHeader(std::ostream& out);
void PrintSummary(const PatchSummary& patch, std::ostream& out);

}  // namespace orient
