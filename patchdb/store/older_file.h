// Files of older programs.
#pragma once

#include <optional>
#include <string>

namespace orient::patchdb {

// The schema version of a file that is older than this program's, which opening it for writing
// brings up to date; empty: it is of today, or there is no file. Throws InputError where it is no
// patch database, or a newer program's.
std::optional<int> OlderVersion(const std::string& path);

}  // namespace orient::patchdb
