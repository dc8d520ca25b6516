// block.json: what a block adjustment says about the block as a whole.
#pragma once

#include <string>
#include <vector>

#include "tools/block/adjustment_stage.h"

namespace orient {

// Writes directory/block.json: sigma0, variance components, parts, calibration, ties and control
// with the state of every sighting, check patches. Returns its path.
std::string WriteBlockJson(const std::string& directory, const AdjustedBlock& adjusted,
                           const std::vector<std::string>& messages);

// Root mean square over the check patches' sightings, px; empty without any.
std::optional<double> CheckRmsPx(const BlockResult& result);

}  // namespace orient
