#include "core/files/partial_files.h"

#include <signal.h>

#include <cerrno>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <system_error>
#include <vector>

namespace orient {
namespace {
namespace fs = std::filesystem;

bool IsRunning(pid_t process) { return kill(process, 0) == 0 || errno != ESRCH; }

// The process that a file's name tells; 0: it is no partial file.
pid_t WriterOf(const std::string& name) {
  static const std::regex kPartial(
      R"(.*\.([0-9]{1,9})(-(?:0|[1-9][0-9]*)\.part|\.part\.gpkg(-journal|-wal|-shm)?))");
  std::smatch match;
  if (!std::regex_match(name, match, kPartial)) return 0;
  return static_cast<pid_t>(std::strtol(match[1].str().c_str(), nullptr, 10));
}

}  // namespace

void RemovePartialFiles(const std::string& folder) {
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end;
       file.increment(error)) {
    const pid_t writer = WriterOf(file->path().filename().string());
    if (writer > 0 && !IsRunning(writer)) left.push_back(file->path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

}  // namespace orient
