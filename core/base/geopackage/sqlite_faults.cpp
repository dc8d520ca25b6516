#include "core/base/geopackage/sqlite_faults.h"

#include <fcntl.h>
#include <sqlite3.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <string>

namespace orient {
namespace {

void (*told)(const char*, const char*, int) = nullptr;

// Preserves errno, which SQLite reads afterwards.
void Tell(const char* doing, const char* path) {
  const int error = errno;
  told(doing, path, error);
  errno = error;
}

template <class Result>
Result Read(int file, Result result) {
  if (result >= 0 || errno == EINTR) return result;  // then SQLite reads once more
  const int error = errno;
  std::array<char, PATH_MAX> path{};
  const std::string link = "/proc/self/fd/" + std::to_string(file);
  if (readlink(link.c_str(), path.data(), path.size() - 1) < 0) path[0] = '\0';
  errno = error;
  Tell("read", path[0] == '\0' ? "a database" : path.data());
  return result;
}

int WatchedOpen(const char* path, int flags, int mode) {
  const int file = open(path, flags, mode);
  if (file < 0 && errno != EINTR) Tell("open", path);
  return file;
}

ssize_t WatchedRead(int file, void* bytes, size_t size) {
  return Read(file, read(file, bytes, size));
}

ssize_t WatchedPread(int file, void* bytes, size_t size, off_t at) {
  return Read(file, pread(file, bytes, size, at));
}

ssize_t WatchedPread64(int file, void* bytes, size_t size, off64_t at) {
  return Read(file, pread64(file, bytes, size, at));
}

template <class Function>
void Replace(sqlite3_vfs* files, const char* name, Function function) {
  // Some exist only in other builds of SQLite.
  if (files->xGetSystemCall(files, name) != nullptr)
    files->xSetSystemCall(files, name, reinterpret_cast<sqlite3_syscall_ptr>(function));
}

}  // namespace

void WatchSqliteFiles(void (*note)(const char* doing, const char* path, int error)) {
  constexpr int kWithSystemCalls = 3;
  sqlite3_vfs* files = sqlite3_vfs_find(nullptr);
  if (files == nullptr || files->iVersion < kWithSystemCalls || files->xSetSystemCall == nullptr ||
      files->xGetSystemCall == nullptr)
    return;
  told = note;
  Replace(files, "open", &WatchedOpen);
  Replace(files, "read", &WatchedRead);
  Replace(files, "pread", &WatchedPread);
  Replace(files, "pread64", &WatchedPread64);
}

}  // namespace orient
