// What a block's run would do.
#pragma once

#include <string>
#include <vector>

#include "block/block_inputs.h"

namespace orient::block {

// One line per photo and stage: "do" or "keep". Throws as the run does.
std::vector<std::string> PlanBlock(const BlockInputs& inputs);

}  // namespace orient::block
