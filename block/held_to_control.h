// GNSS and approximations make no photo ok, and keep no block from converging: where they are
// observed, a block is adjusted a second time without them.
#pragma once

#include "block/stages/adjustment_stage.h"

namespace orient::block {

// The block `with` them, no photo of it better than it is `without`; where only the block without
// them converges, that one, with a finding that says so.
JudgedBlock HeldToControl(JudgedBlock with, JudgedBlock without);

}  // namespace orient::block
