// Control of PAT-B and BINGO as frame_measures.h describes it. Private to core/exchange.
#pragma once

#include <string>
#include <vector>

#include "core/exchange/text_lines.h"
#include "core/measurements/gathered_measurements.h"

namespace orient {

// A line -99: a photo's points, or a block of control, end.
bool IsEnd(const TextLine& line);
// Whether it is a code (standard deviation, additional parameter ...): an integer from 0 to 999.
bool IsCode(const std::string& word);

// All lines of a file of control. Points of one block only are left out and noted.
void AddPatbControl(const std::string& path, const std::vector<TextLine>& lines, double sigma_m,
                    GatheredMeasurements* all);
// A line CONT.
void AddBingoControl(const TextLine& line, double sigma_m, GatheredMeasurements* all);

}  // namespace orient
