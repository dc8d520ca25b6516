// What a person should know about an adjusted block as a whole. Private to block.
#pragma once

#include "block/bundle/bundle.h"
#include "block/bundle/bundle_result.h"

namespace orient::block {

// Of its parts, of GNSS and approximations that do not fit, of what the observations leave open.
// `result` is complete but for these.
Findings FindingsOfAdjusted(const BlockToAdjust& block, const BlockOptions& options,
                            const BlockResult& result);

}  // namespace orient::block
