#include "patchdb/store/lock_holder.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

namespace orient::patchdb {
namespace {

// SQLite's locks (sqlite3.c, "WAL-index" and "os_unix"): byte 120 of DB-shm is the log's writer,
// those from 1 GiB of DB itself are the rollback journal's.
constexpr long kLogWriterByte = 120;

unsigned long InodeOf(const std::string& path) {
  struct stat status = {};
  return stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

std::string CommandOf(long pid) {
  std::ifstream file(fmt::format("/proc/{}/cmdline", pid), std::ios::binary);
  std::string command((std::istreambuf_iterator<char>(file)), {});
  while (!command.empty() && command.back() == '\0') command.pop_back();
  std::replace(command.begin(), command.end(), '\0', ' ');
  constexpr std::size_t kShown = 120;
  if (command.size() > kShown) {
    command.resize(kShown);
    command += " ...";
  }
  return command;
}

struct Lock {
  bool writes = false;
  long pid = 0;
  unsigned long inode = 0;
  long first = 0;
};

// "1: POSIX  ADVISORY  WRITE 7895 fe:00:10955712 120 120"; waiting ones have "->" after the number.
bool ReadLock(const std::string& line, Lock* lock) {
  std::istringstream words(line);
  std::string number, kind, advice, access, place;
  if (!(words >> number >> kind >> advice >> access >> lock->pid >> place >> lock->first))
    return false;
  lock->writes = access == "WRITE";
  const std::size_t colon = place.rfind(':');
  if (kind != "POSIX" || colon == std::string::npos) return false;
  lock->inode = std::strtoul(place.c_str() + colon + 1, nullptr, 10);
  return true;
}

}  // namespace

std::string LockHolder(const std::string& path) {
  const unsigned long file = InodeOf(path), log = InodeOf(path + "-shm");
  std::ifstream locks("/proc/locks");
  std::string line;
  while (std::getline(locks, line)) {
    Lock lock;
    if (!ReadLock(line, &lock) || !lock.writes || lock.inode == 0 || lock.pid <= 0) continue;
    const bool holds = (lock.inode == log && lock.first == kLogWriterByte) || lock.inode == file;
    if (!holds) continue;
    if (lock.pid == getpid()) return "this program itself";
    const std::string command = CommandOf(lock.pid);
    std::string holder = "process " + std::to_string(lock.pid);
    if (!command.empty()) holder += fmt::format(" ({})", command);
    return holder;
  }
  return "";
}

}  // namespace orient::patchdb
