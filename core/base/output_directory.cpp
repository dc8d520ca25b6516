#include "core/base/output_directory.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/partial_files.h"

namespace orient {
namespace fs = std::filesystem;

void MakeOutputDirectory(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (!error && fs::is_directory(directory)) return RemovePartialFiles(directory);
  const std::string what =
      fmt::format("cannot create the folder {}: {}", directory,
                  error ? error.message() : "a file of this name is in the way");
  if (IsOfEnvironment(error.value())) throw EnvironmentError(what);
  throw InputError(what);
}

}  // namespace orient
