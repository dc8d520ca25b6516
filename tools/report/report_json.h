// report.json: the report's figures for programs.
#pragma once

#include <string>

#include "tools/report/verdict.h"

namespace orient {

// Returns its path. Lengths in m, angles in degrees, residuals in px; absent figures are null.
// Throws InputError where it cannot be written.
std::string WriteReportJson(const BlockRecord& block, const BlockVerdict& verdict);

}  // namespace orient
