#include "block/inputs/camera_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <system_error>

#include "block/inputs/mark_shapes.h"
#include "core/base/error.h"

namespace orient::block {
namespace {
namespace fs = std::filesystem;

constexpr const char* kFormatOnly = "format_only";

bool IsFolder(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error);
}

bool IsFile(const fs::path& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// Where the program lies; empty where the system does not say.
fs::path ProgramFolder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return error ? fs::path() : program.parent_path();
}

std::vector<fs::path> CameraFilesIn(const fs::path& folder) {
  std::vector<fs::path> files;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".toml") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

// Names that share their beginning with what was asked for, at most five; all where none does.
std::string Similar(const std::string& name, const fs::path& folder) {
  std::string all, similar;
  int count = 0;
  for (const fs::path& sub : {folder, folder / kFormatOnly})
    for (const fs::path& file : CameraFilesIn(sub)) {
      const std::string known = file.stem().string();
      all += (all.empty() ? "" : ", ") + known;
      if (known.compare(0, 4, name, 0, 4) != 0 || ++count > 5) continue;
      similar += (similar.empty() ? "" : ", ") + known;
    }
  return similar.empty() ? all : similar;
}

}  // namespace

std::string CameraLibraryFolder(const std::string& option) {
  if (!option.empty()) {
    if (!IsFolder(option))
      throw InputError("the camera library " + option + " is not a folder (--camera-library)");
    return option;
  }
  if (const char* variable = std::getenv("ORIENT_CAMERAS"); variable && *variable != '\0') {
    if (!IsFolder(variable))
      throw InputError(fmt::format("ORIENT_CAMERAS names {}, which is not a folder", variable));
    return variable;
  }
  const fs::path beside = ProgramFolder() / ".." / "share" / "orient" / "cameras";
  for (const fs::path& folder : {beside, fs::path(ORIENT_SOURCE_CAMERAS)})
    if (IsFolder(folder)) return folder.lexically_normal().string();
  throw InputError(
      "the camera library is not beside the program; give its folder with "
      "--camera-library or ORIENT_CAMERAS");
}

std::vector<LibraryCamera> ReadCameraLibrary(const std::string& folder) {
  std::vector<LibraryCamera> cameras;
  for (const bool format_only : {false, true}) {
    const fs::path place = format_only ? fs::path(folder) / kFormatOnly : fs::path(folder);
    for (const fs::path& path : CameraFilesIn(place)) {
      LibraryCamera camera{path.stem().string(), path.string(), format_only, {}, {}};
      camera.file = ReadCameraFile(camera.path);
      camera.shapes = LoadMarkShapes(camera.file);
      cameras.push_back(std::move(camera));
    }
  }
  if (cameras.empty()) throw InputError(folder + " holds no camera files (*.toml)");
  return cameras;
}

std::string FindCameraFile(const std::string& path_or_name, const std::string& library_option) {
  const fs::path asked(path_or_name);
  if (IsFile(asked) || asked.has_parent_path() || asked.has_extension()) return path_or_name;
  const fs::path folder = CameraLibraryFolder(library_option);
  for (const fs::path& place : {folder, folder / kFormatOnly}) {
    const fs::path file = place / (path_or_name + ".toml");
    if (IsFile(file)) return file.string();
  }
  throw InputError(fmt::format("camera {} is neither a file nor in the library {}; there are {}",
                               path_or_name, folder.string(), Similar(path_or_name, folder)));
}

}  // namespace orient::block
