// Patches as lines of CSV; an empty cell is unknown.
#pragma once

#include <ostream>
#include <string>

#include "patchdb/store/selection.h"

namespace orient {

// Both without the line's end, so that a verb may add columns.
void PrintSummaryHeader(std::ostream& out);
void PrintSummary(const patchdb::PatchSummary& patch, std::ostream& out);

}  // namespace orient
