// Who keeps a database from being written.
#pragma once

#include <string>

namespace orient::patchdb {

// "process 4711 (orient patchdb harvest ...)": the one that has a write lock on the file or its
// write-ahead log, from the kernel's table of locks; "this program itself"; empty where the kernel
// does not say. Nothing is kept in a file of its own, so nothing is stale after a crash.
std::string LockHolder(const std::string& path);

}  // namespace orient::patchdb
