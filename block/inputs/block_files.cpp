#include "block/inputs/block_files.h"

#include <filesystem>

namespace orient::block {
namespace fs = std::filesystem;

std::vector<std::string> FolderFiles(const std::string& directory) {
  std::vector<std::string> paths;
  for (const char* file : kFolderFiles) paths.push_back((fs::path(directory) / file).string());
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
