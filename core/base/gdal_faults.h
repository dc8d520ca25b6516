// What the machine refuses to GDAL: opening, reading and writing files (a device that fails, too
// many open files, no space), and memory. GDAL reports this as a damaged file, or not at
// all: an overview that cannot be opened counts as absent. Its file access, including that of its
// databases, is therefore watched, and its error messages are examined.
#pragma once

#include <cstddef>
#include <string>

namespace orient {

// Files that GDAL opens from now on, in the file system and over the network.
void WatchGdalFiles();

// For handlers of GDAL's errors: CPLErrorNum and what was said.
void NoteGdalError(int number, const char* text);

// The server's answer to GDAL's last failed request for a remote file on this thread.
// kUnanswered: neither "not found" nor "forbidden": the server is busy, slow or silent.
enum class RemoteAnswer { kNothingSaid, kNotThere, kForbidden, kUnanswered };
RemoteAnswer LastRemoteAnswer();

// Drops what GDAL has cached of a remote file, as another program may have rewritten it since.
void ForgetRemoteFile(const std::string& path);

// On this thread, while an object of this class lives.
class GdalFaults {
 public:
  GdalFaults();
  // Throws EnvironmentError: names the file that the machine did not open, read or write, or says
  // that there is no memory left.
  void ThrowIfAny() const;
  // There was none, or a file asked for more than any machine has.
  bool OutOfMemory() const;

 private:
  std::size_t files_before_, memory_before_;
};

// The result of `work` (opening, reading), or EnvironmentError. What GDAL says it had no memory for
// is done once more: memory may be free by now, and only otherwise it is the file's fault.
template <typename Work>
auto Watched(const Work& work) {
  for (bool again = false;; again = true) {
    const GdalFaults faults;
    auto result = work();
    faults.ThrowIfAny();
    if (again || !faults.OutOfMemory()) return result;
  }
}

}  // namespace orient
