// What killed programs leave of files that were to appear whole (core/base/new_file.h):
// <name>.<process>-<n>-<machine>.part, and SQLite's logs of such a file. Machines share folders: a
// process number says something on its own machine only.
#pragma once

#include <string>
#include <string_view>

namespace orient {

// The n-th name of this process for a file to be.
std::string PartialName(const std::string& target, int n);

// By the file name alone.
bool IsPartialFile(std::string_view name);

// Whether its process still runs; on another machine: whether it was written to within a day.
bool IsBeingWritten(const std::string& path);

// Removes those in a folder, not below it, that nobody writes any more. What cannot be removed
// stays.
void RemovePartialFiles(const std::string& folder);

}  // namespace orient
