// What a command line of `orient interior` or `orient exterior` asks for, without running it: for
// doing again what such a command did (run.json has its arguments).
#pragma once

#include <string>
#include <vector>

#include "block/stages/exterior_setting.h"
#include "block/stages/interior_stage.h"

namespace orient {

// Arguments as typed, the command's name first. Throw UsageError, InputError as the command does.
block::InteriorRunOptions InteriorRunOf(const std::vector<std::string>& arguments);
block::ExteriorRunOptions ExteriorRunOf(const std::vector<std::string>& arguments);

}  // namespace orient
