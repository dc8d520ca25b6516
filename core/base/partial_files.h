// What killed programs leave of files that were to appear whole (core/base/atomic_write.h and
// GeoPackages): <name>.<process>-<n>.part, <name>.<process>.part.gpkg and its journal.
#pragma once

#include <string>

namespace orient {

// Removes those in a folder, not below it, whose process is not running on this machine any more.
// What cannot be removed stays.
void RemovePartialFiles(const std::string& folder);

}  // namespace orient
