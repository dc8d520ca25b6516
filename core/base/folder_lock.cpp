#include "core/base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "core/base/error.h"

namespace orient {

FolderLock::FolderLock(const std::string& folder, const std::string& file_name, Mode mode)
    : path_((std::filesystem::path(folder) / file_name).string()), mode_(mode) {
  file_ = open(path_.c_str(), O_CREAT | O_RDWR | O_CLOEXEC, 0644);
  if (file_ < 0 || flock(file_, (mode == Mode::kAlone ? LOCK_EX : LOCK_SH) | LOCK_NB) == 0 ||
      errno != EWOULDBLOCK)
    return;
  close(file_);
  throw InputError(folder +
                   ": another program is writing into this folder; wait until it has finished, or "
                   "name another one");
}

FolderLock::~FolderLock() {
  if (file_ < 0) return;
  // Others that share it would hold a file without a name, and one that wants it alone another.
  if (mode_ == Mode::kAlone) unlink(path_.c_str());
  close(file_);
}

}  // namespace orient
