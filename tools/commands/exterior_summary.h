// What a person reads at the end of a run over photos.
#pragma once

#include <iosfwd>
#include <vector>

#include "core/files/results.h"

namespace orient {

// One row per photo: status, patches matched of searched, sigma0, precision, the first message.
void PrintExteriorSummary(const std::vector<ExteriorResult>& results, std::ostream& out);

// No photo failed. A weak one is oriented.
bool AllOriented(const std::vector<ExteriorResult>& results);

}  // namespace orient
