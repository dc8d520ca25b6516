// What the machine refuses to GDAL: opening, reading and writing files (a device that fails, too
// many open files, no room), and memory. GDAL tells of it as if the file were damaged, or not at
// all: an overview that cannot be opened is none. Its files are therefore watched, those of its
// databases too, its errors listened to.
#pragma once

#include <cstddef>
#include <string>

namespace orient {

// Files that GDAL opens from now on, in the file system and over the network.
void WatchGdalFiles();

// For handlers of GDAL's errors: CPLErrorNum and what was said.
void NoteGdalError(int number, const char* text);

// What a server has said to this thread's last question of GDAL for a remote file that failed.
// kUnanswered: neither that there is none, nor that it is none for us: it is busy, slow, or silent.
enum class RemoteAnswer { kNothingSaid, kNotThere, kForbidden, kUnanswered };
RemoteAnswer LastRemoteAnswer();

// What GDAL keeps of a remote file, which another program may have written since it asked.
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
