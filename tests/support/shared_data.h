// Location of the real data: ORIENT_SHARED_DATA, default ../shared/data beside the project.
#pragma once

#include <optional>
#include <string>

namespace orient {

// The path of a file or folder of the real data; empty if it is absent, so that a test can skip.
std::optional<std::string> SharedData(const std::string& relative_path);

// A file of the project itself, e.g. "data/cameras/wild_rc10.toml".
std::string ProjectFile(const std::string& relative_path);

// A new empty folder for the running test, removed when the object is destroyed.
class TemporaryFolder {
 public:
  TemporaryFolder();
  ~TemporaryFolder();
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& Path() const { return path_; }

 private:
  std::string path_;
};

// A seed derived from the running test's name, so that the order of tests does not matter.
unsigned TestSeed();

}  // namespace orient

// Skips the test with a message if real data is absent; otherwise `variable` is its path.
#define ORIENT_REQUIRE_SHARED_DATA(variable, relative_path)                       \
  const auto variable##_or = ::orient::SharedData(relative_path);                 \
  if (!variable##_or)                                                             \
    GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): " << (relative_path); \
  const std::string& variable = *variable##_or  // NOLINT(bugprone-macro-parentheses)
