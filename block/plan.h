// What a block's run would do.
#pragma once

#include <string>
#include <vector>

#include "block/block_inputs.h"

namespace orient::block {

// "do    <what>" or "keep  <what>".
std::string PlanLine(bool keep, const std::string& what);

// One line per photo and stage. Throws as the run does.
std::vector<std::string> PlanBlock(const BlockInputs& inputs);

}  // namespace orient::block
