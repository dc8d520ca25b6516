// Tables (CSV) of image points or ground points, with a header (measured_columns.h). Private to
// core/exchange.
#pragma once

#include <string>

#include "core/measurements/gathered_measurements.h"

namespace orient {

// Cells are separated by commas, semicolons or tabs, whichever makes the first line (or a comment)
// a header; with semicolons and tabs, numbers may have decimal commas. Pixels as ours, mm of the
// photo system, metres. Accuracies that are not given are `sigma`'s, and noted, as are columns that
// are not read.
//
// Throws InputError naming file, line, column and value.
void AddMeasuredTable(const std::string& path, const MeasuredSigma& sigma,
                      GatheredMeasurements* all);

}  // namespace orient
