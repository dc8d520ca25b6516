// The exterior orientation of one photo from its files.
#pragma once

#include <string>

#include "block/stages/exterior_setting.h"
#include "core/files/results.h"

namespace orient::block {

// Oriented within its approximation's accuracy, else by a search of the whole photo; draws
// <photo>.patches.png. An error caused by the photo's files fails this photo only.
ExteriorResult OrientFromFiles(const ExteriorSetting& setting, const std::string& path);

}  // namespace orient::block
