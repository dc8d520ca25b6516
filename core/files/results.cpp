#include "core/files/results.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>

#include "core/base/error.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kInteriorSuffix = ".interior.json";

std::string ResultPath(const std::string& directory, const std::string& photo, const char* suffix) {
  return (std::filesystem::path(directory) / (photo + suffix)).string();
}

}  // namespace

std::string_view Name(Polarity polarity) {
  switch (polarity) {
    case Polarity::kPositive:
      return "positive";
    case Polarity::kNegative:
      return "negative";
  }
  throw std::invalid_argument("Name: not a Polarity");
}

std::string_view Name(MarkState state) {
  switch (state) {
    case MarkState::kUsed:
      return "used";
    case MarkState::kRejected:
      return "rejected";
    case MarkState::kMissing:
      return "missing";
  }
  throw std::invalid_argument("Name: not a MarkState");
}

std::string_view Name(PatchState state) {
  switch (state) {
    case PatchState::kMatched:
      return "matched";
    case PatchState::kNotFound:
      return "not_found";
    case PatchState::kRejected:
      return "rejected";
    case PatchState::kNotVisible:
      return "not_visible";
  }
  throw std::invalid_argument("Name: not a PatchState");
}

std::vector<std::string> InteriorResultPaths(const std::string& directory) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(directory, error))
    if (entry.path().string().ends_with(kInteriorSuffix)) paths.push_back(entry.path().string());
  if (error)
    throw InputError(directory + ": cannot be listed (" + error.message() +
                     "); name the folder that 'orient interior' wrote");
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string InteriorResultPath(const std::string& directory, const std::string& photo) {
  return ResultPath(directory, photo, kInteriorSuffix);
}

std::string ExteriorResultPath(const std::string& directory, const std::string& photo) {
  return ResultPath(directory, photo, ".exterior.json");
}

}  // namespace orient
