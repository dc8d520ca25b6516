// What a person should know about an adjusted block as a whole. Private to block.
#pragma once

#include "block/bundle/equations.h"

namespace orient::block {

// Of its parts, of GNSS and approximations that do not fit, of what the observations leave open.
// `result` is complete but for these.
Findings FindingsOfAdjusted(const BlockSystem& system, const BlockResult& result);

}  // namespace orient::block
