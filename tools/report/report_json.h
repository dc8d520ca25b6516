// report.json: the report's figures for programs.
#pragma once

#include <string>

#include "tools/report/block_record.h"

namespace orient {

// Returns its path. Lengths in m, angles in degrees, residuals in px; absent figures are null.
// Throws InputError where it cannot be written.
std::string WriteReportJson(const BlockRecord& block);

}  // namespace orient
