// Files appear whole or not at all.
#pragma once

#include <string>
#include <string_view>

namespace orient {

// Writes beside `path`, flushes to disk and renames. Throws InputError naming path and cause (a
// read-only folder), EnvironmentError where there is no space or the device fails.
void WriteFileAtomically(const std::string& path, std::string_view contents);

// Whole contents; throws InputError naming the path.
std::string ReadFile(const std::string& path);

}  // namespace orient
