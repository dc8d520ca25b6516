#include "tests/support/shared_data.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>

namespace orient {
namespace fs = std::filesystem;

std::optional<std::string> SharedData(const std::string& relative_path) {
  const char* root = std::getenv("ORIENT_SHARED_DATA");
  const fs::path folder = root != nullptr ? root : ORIENT_DEFAULT_SHARED_DATA;
  // Without "..", like the paths that the program prints.
  const fs::path path = (folder / relative_path).lexically_normal();
  if (!fs::exists(path)) return std::nullopt;
  return path.string();
}

std::string ProjectFile(const std::string& relative_path) {
  return (fs::path(ORIENT_PROJECT_FOLDER) / relative_path).string();
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (fs::temp_directory_path() / "orient-test-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;  // a destructor must not throw; a leftover folder in /tmp is harmless
  fs::remove_all(path_, ignored);
}

unsigned TestSeed() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  // FNV-1a: stable between library versions, unlike std::hash.
  unsigned hash = 2166136261u;
  for (const char c : std::string(info->test_suite_name()) + "." + info->name())
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
  return hash;
}

}  // namespace orient
