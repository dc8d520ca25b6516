// To spare patch databases that lie where a result would be written.
#pragma once

#include <string>

namespace orient::patchdb {

// Whether the file is a patch database, of whatever version; false where it is something else or
// damaged. Throws EnvironmentError where the machine does not read it.
bool IsPatchDatabase(const std::string& path);

}  // namespace orient::patchdb
