#include "core/base/partial_files.h"

#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string_view>
#include <system_error>
#include <vector>

#include "core/base/number_text.h"

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
  return std::max(NumberIn<pid_t>(digits).value_or(0), 0);
}

bool IsCount(std::string_view digits) {
  return digits == "0" || (ProcessOf(digits) > 0 && digits[0] != '0');
}

// Eight digits for what gives processes their numbers: a machine, or a container on it. Copies of a
// machine that share its name and id are told apart by their containers only.
const std::string& ThisMachine() {
  static const std::string machine = [] {
    std::array<char, 256> host{};
    gethostname(host.data(), host.size() - 1);
    std::string id;
    std::ifstream("/etc/machine-id") >> id;
    std::error_code none;
    const std::string processes = fs::read_symlink("/proc/self/ns/pid", none).string();
    const auto sum = std::hash<std::string>()(fmt::format("{} {} {}", host.data(), id, processes));
    return fmt::format("{:08x}", static_cast<std::uint32_t>(sum));
  }();
  return machine;
}

struct Writer {
  pid_t process = 0;
  std::string_view machine;
};

std::optional<Writer> WriterOf(std::string_view name) {
  // Side files of SQLite, and GDAL's temporary files for a cloud optimized GeoTIFF.
  for (const std::string_view beside : {"-journal", "-wal", "-shm", ".msk.ovr.tmp", ".ovr.tmp"})
    if (TakeEnd(&name, beside)) break;
  if (!TakeEnd(&name, ".part")) return std::nullopt;
  const std::size_t dot = name.rfind('.');
  if (dot == std::string_view::npos) return std::nullopt;
  const std::string_view writer = name.substr(dot + 1);
  const std::size_t first = writer.find('-'), second = writer.rfind('-');
  if (first == std::string_view::npos) return std::nullopt;
  const pid_t process = ProcessOf(writer.substr(0, first));
  if (first == second) {  // an earlier version named no machine
    if (process == 0 || !IsCount(writer.substr(first + 1))) return std::nullopt;
    return Writer{process, ""};
  }
  const std::string_view count = writer.substr(first + 1, second - first - 1);
  const std::string_view machine = writer.substr(second + 1);
  const bool named = machine.size() == ThisMachine().size() &&
                     machine.find_first_not_of("0123456789abcdef") == std::string_view::npos;
  if (process == 0 || !IsCount(count) || !named) return std::nullopt;
  return Writer{process, machine};
}

}  // namespace

std::string PartialName(const std::string& target, int n) {
  return fmt::format("{}.{}-{}-{}.part", target, getpid(), n, ThisMachine());
}

bool IsPartialFile(std::string_view name) { return WriterOf(name).has_value(); }

bool IsBeingWritten(const std::string& path) {
  const std::string name = fs::path(path).filename().string();
  const auto writer = WriterOf(name);
  if (!writer) return false;
  if (writer->machine == ThisMachine()) return IsRunning(writer->process);
  std::error_code error;
  const auto written = fs::last_write_time(path, error);
  return error || fs::file_time_type::clock::now() - written < std::chrono::hours(24);
}

void RemovePartialFiles(const std::string& folder) {
  std::vector<fs::path> left;
  std::error_code error;
  for (fs::directory_iterator file(folder, error), end; !error && file != end;
       file.increment(error)) {
    const std::string path = file->path().string();
    if (IsPartialFile(file->path().filename().string()) && !IsBeingWritten(path))
      left.push_back(file->path());
  }
  for (const fs::path& path : left) fs::remove(path, error);
}

}  // namespace orient
