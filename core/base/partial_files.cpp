#include "core/base/partial_files.h"

#include <signal.h>

#include <cerrno>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

namespace orient {
namespace {
namespace fs = std::filesystem;

bool IsRunning(pid_t process) { return kill(process, 0) == 0 || errno != ESRCH; }

bool TakeEnd(std::string_view* text, std::string_view end) {
  if (!text->ends_with(end)) return false;
  text->remove_suffix(end.size());
  return true;
}

// The process id given by these digits; 0: they are not a possible one.
pid_t ProcessOf(std::string_view digits) {
  pid_t process = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), process);
  return error == std::errc() && end == digits.data() + digits.size() && process > 0 ? process : 0;
}

// The id of the writing process, from the name of a partial file; 0: not a partial file.
pid_t WriterOf(std::string_view name) {
  // Side files of SQLite, and GDAL's temporary files for a cloud optimized GeoTIFF.
  for (const std::string_view beside : {"-journal", "-wal", "-shm", ".msk.ovr.tmp", ".ovr.tmp"})
    if (TakeEnd(&name, beside)) break;
  if (!TakeEnd(&name, ".part")) return 0;
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return 0;
  const std::string_view number = name.substr(dot + 1);
  const std::size_t hyphen = number.find('-');
  if (hyphen == std::string_view::npos) return 0;
  const std::string_view count = number.substr(hyphen + 1);
  const bool counts = count == "0" || (ProcessOf(count) > 0 && count[0] != '0');
  return counts ? ProcessOf(number.substr(0, hyphen)) : 0;
}

}  // namespace

bool IsPartialFile(std::string_view name) { return WriterOf(name) > 0; }

bool IsBeingWritten(std::string_view name) {
  return IsPartialFile(name) && IsRunning(WriterOf(name));
}

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
