#include "tests/fuzz/reader.h"

#include <cpl_vsi.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace orient::fuzz {
namespace {
namespace fs = std::filesystem;

// One thread: an input has the same effect every time, and no input waits for others.
const tbb::global_control kOneThread(tbb::global_control::max_allowed_parallelism, 1);

// In memory if possible: flushing costs nothing there.
fs::path TemporaryPlace() {
  const fs::path memory = "/dev/shm";
  return access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path();
}

struct OwnFolder {
  std::string path = (TemporaryPlace() / ("orient_fuzz_" + std::to_string(getpid()))).string();
  OwnFolder() { fs::create_directories(path); }
  ~OwnFolder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

}  // namespace

std::map<std::string, Reader>& Readers() {
  static std::map<std::string, Reader> readers;
  return readers;
}

const std::string& Folder() {
  static const OwnFolder folder;
  return folder.path;
}

std::string FileWith(const std::string& name, std::string_view contents) {
  const fs::path path = fs::path(Folder()) / name;
  fs::create_directories(path.parent_path());
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file.write(contents.data(), static_cast<std::streamsize>(contents.size()));
  return path.string();
}

std::string MemoryFileWith(const std::string& name, Input contents) {
  const std::string path = "/vsimem/" + name;
  // GDAL only reads it.
  auto* bytes = const_cast<GByte*>(contents.data());
  VSIFCloseL(VSIFileFromMemBuffer(path.c_str(), bytes, contents.size(), FALSE));
  return path;
}

std::vector<std::string_view> Parts(Input input) {
  constexpr std::string_view kBetween = "====\n";
  std::vector<std::string_view> parts;
  std::string_view rest = Text(input);
  for (std::size_t end; (end = rest.find(kBetween)) != std::string_view::npos;) {
    parts.push_back(rest.substr(0, end));
    rest.remove_prefix(end + kBetween.size());
  }
  parts.push_back(rest);
  return parts;
}

void Require(bool holds, const std::string& what) {
  if (holds) return;
  std::fprintf(stderr, "not as it must be: %s\n", what.c_str());
  std::abort();
}

}  // namespace orient::fuzz
