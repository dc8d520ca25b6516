// One program at a time writes into a folder, or several that agree to share it.
#pragma once

#include <string>

namespace orient {

// Held as long as the object lives; a program that is killed holds nothing. The lock is a file in
// the folder, which goes with it. File systems that know no locks are written to without one.
class FolderLock {
 public:
  enum class Mode { kAlone, kShared };
  // Throws InputError where another program holds it, of kShared only where one holds it alone.
  FolderLock(const std::string& folder, const std::string& file_name, Mode mode = Mode::kAlone);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::string path_;
  int file_ = -1;
  Mode mode_;
};

}  // namespace orient
