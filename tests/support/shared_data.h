// Where the real data lies: ORIENT_SHARED_DATA, default ../shared/data beside the project.
#pragma once

#include <optional>
#include <string>

namespace orient {

// The path of a file or folder of the real data; empty where it is absent, so that a test skips.
std::optional<std::string> SharedData(const std::string& relative_path);

// A file of the project itself, e.g. "data/cameras/wild_rc10.toml".
std::string ProjectFile(const std::string& relative_path);

// A new empty folder that belongs to the running test, removed when the object dies.
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

// A seed that derives from the running test's name, so that order never matters.
unsigned TestSeed();

}  // namespace orient

// Skips the test with a clear word where real data is absent; otherwise `variable` is its path.
#define ORIENT_REQUIRE_SHARED_DATA(variable, relative_path)                       \
  const auto variable##_or = ::orient::SharedData(relative_path);                 \
  if (!variable##_or)                                                             \
    GTEST_SKIP() << "real data absent (ORIENT_SHARED_DATA): " << (relative_path); \
  const std::string& variable = *variable##_or  // NOLINT(bugprone-macro-parentheses)
