#include "block/inputs/block_files.h"

#include <filesystem>

namespace orient::block {
namespace {
namespace fs = std::filesystem;

template <std::size_t kCount>
void Add(const std::array<const char*, kCount>& names, const std::string& directory,
         std::vector<std::string>* paths) {
  for (const char* name : names) paths->push_back((fs::path(directory) / name).string());
}

}  // namespace

std::vector<std::string> InteriorFiles(const std::string& directory) {
  std::vector<std::string> paths;
  Add(kInteriorFiles, directory, &paths);
  return paths;
}

std::vector<std::string> ExteriorFiles(const std::string& directory) {
  std::vector<std::string> paths;
  Add(kExteriorFiles, directory, &paths);
  return paths;
}

std::vector<std::string> BlockFiles(const std::string& directory) {
  std::vector<std::string> paths;
  Add(kInteriorFiles, directory, &paths);
  Add(kExteriorFiles, directory, &paths);
  Add(kBlockFiles, directory, &paths);
  return paths;
}

std::vector<std::string> PhotoFiles(const std::string& directory,
                                    const std::vector<std::string>& photos) {
  std::vector<std::string> paths;
  for (const std::string& photo : photos)
    for (const char* file : kPhotoFiles)
      paths.push_back((fs::path(directory) / (photo + file)).string());
  return paths;
}

}  // namespace orient::block
