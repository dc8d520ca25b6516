// What killed programs leave of files that were to appear whole (core/base/new_file.h):
// <name>.<process>-<n>.part, and SQLite's logs of such a file.
#pragma once

#include <string>
#include <string_view>

namespace orient {

// By the file name alone: whether it is partial; whether its process still runs on this machine.
bool IsPartialFile(std::string_view name);
bool IsBeingWritten(std::string_view name);

// Removes those in a folder, not below it, whose process is not running on this machine any more.
// What cannot be removed stays.
void RemovePartialFiles(const std::string& folder);

}  // namespace orient
