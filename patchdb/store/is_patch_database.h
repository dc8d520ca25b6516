#pragma once

#include <string>

namespace orient::patchdb {

// Whether the file is a patch database, of whatever version; false where it cannot be read.
bool IsPatchDatabase(const std::string& path);

}  // namespace orient::patchdb
