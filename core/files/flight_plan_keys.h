// The tables [flight] and [[strips]] of a block file. Private to core/files.
#pragma once

#include <string>
#include <vector>

#include "core/files/flight_plan.h"
#include "core/files/toml_fields.h"

namespace orient {

// `photos`: names of all photos of the block, which patterns ("05_*") must match. A plain name that
// is none of them keeps its place in the strip. Throws InputError naming strip and photo.
FlightPlan ReadFlightPlan(const TomlTable& root, const std::vector<std::string>& photos);

}  // namespace orient
