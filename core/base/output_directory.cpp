#include "core/base/output_directory.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "core/base/error.h"

namespace orient {
namespace fs = std::filesystem;

void MakeOutputDirectory(const std::string& directory) {
  std::error_code error;
  fs::create_directories(directory, error);
  if (error || !fs::is_directory(directory))
    throw InputError(fmt::format("cannot create the folder {}: {}", directory,
                                 error ? error.message() : "a file of this name is in the way"));
}

}  // namespace orient
