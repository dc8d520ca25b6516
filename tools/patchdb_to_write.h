// A patch database for a command that writes.
#pragma once

#include <iosfwd>
#include <string>

#include "patchdb/patch_database.h"

namespace orient {

// Opened for writing. A file of an older program is brought up to date, and `out` hears of it.
PatchDatabase OpenToWrite(const std::string& path, std::ostream& out);

}  // namespace orient
