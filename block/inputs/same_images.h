// Photos of a block that are one image under two names.
#pragma once

#include <string>
#include <vector>

#include "core/files/finding.h"

namespace orient::block {

// One finding for each image that several of the files hold (DigestOfFile), naming its photos.
// Files that cannot be read are nobody's copy.
Findings SameImages(const std::vector<std::string>& paths);

}  // namespace orient::block
