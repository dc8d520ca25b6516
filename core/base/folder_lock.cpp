#include "core/base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <utility>

#include "core/base/error.h"

namespace orient {

namespace {

// Whether `file` is still the one of this name: a process that held the lock alone unlinks the file
// when it ends, perhaps after we opened it and before we locked it.
bool HasName(int file, const std::string& path) {
  struct stat own {
  }, named{};
  return fstat(file, &own) == 0 && stat(path.c_str(), &named) == 0 && own.st_ino == named.st_ino &&
         own.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder, const std::string& file_name, Mode mode)
    : path_((std::filesystem::path(folder) / file_name).string()), mode_(mode) {
  constexpr int kMostTries = 100;
  for (int i = 0; i < kMostTries; ++i) {
    file_ = open(path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
    if (file_ < 0) return;
    if (flock(file_, (mode == Mode::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB) != 0) {
      if (errno != EWOULDBLOCK) return;
      break;
    }
    if (HasName(file_, path_)) return;
    close(std::exchange(file_, -1));
  }
  if (file_ >= 0) close(file_);
  throw InputError(
      folder +
      ": another orient is at work in this folder (a review until it is closed); wait until it "
      "has ended, or name another folder");
}

FolderLock::~FolderLock() {
  if (file_ < 0) return;
  // If shared, other holders would be left with an unlinked file, and newcomers lock another one.
  if (mode_ == Mode::kAlone) unlink(path_.c_str());
  close(file_);
}

}  // namespace orient
