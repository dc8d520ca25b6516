#include "core/base/atomic_write.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <stdexcept>

#include "core/base/environment_error.h"
#include "core/base/error.h"

namespace orient {
namespace {

std::string Remedy(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "; create its folder first";
    case EACCES:
    case EPERM:
    case EROFS:
      return "; choose a folder that you may write to";
    case ENOSPC:
    case EDQUOT:
      return "; free some space and run again";
    default:
      return "";
  }
}

[[noreturn]] void FailToWrite(const std::string& path, int error) {
  const std::string what =
      fmt::format("cannot write {}: {}{}", path, std::strerror(error), Remedy(error));
  if (IsOfEnvironment(error)) throw EnvironmentError(what);
  throw InputError(what);
}

// A file beside the target that nobody else writes; closed and removed unless renamed.
class PartialFile {
 public:
  explicit PartialFile(const std::string& target) : target_(target) {
    const std::string stem = fmt::format("{}.{}-", target, getpid());
    for (int attempt = 0;; ++attempt) {
      path_ = fmt::format("{}{}.part", stem, attempt);
      descriptor_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ >= 0) return;
      if (errno != EEXIST) FailToWrite(target_, errno);
    }
  }
  PartialFile(const PartialFile&) = delete;
  PartialFile& operator=(const PartialFile&) = delete;
  ~PartialFile() {
    if (descriptor_ >= 0) close(descriptor_);
    if (!renamed_) unlink(path_.c_str());
  }

  void Write(std::string_view contents) {
    while (!contents.empty()) {
      const ssize_t written = write(descriptor_, contents.data(), contents.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) FailToWrite(target_, errno);
      contents.remove_prefix(static_cast<size_t>(written));
    }
  }

  void Rename() {
    if (fsync(descriptor_) != 0 && errno != EINVAL) FailToWrite(target_, errno);
    const int closed = close(descriptor_);
    descriptor_ = -1;
    if (closed != 0) FailToWrite(target_, errno);
    if (rename(path_.c_str(), target_.c_str()) != 0) FailToWrite(target_, errno);
    renamed_ = true;
  }

 private:
  std::string target_;
  std::string path_;
  int descriptor_ = -1;
  bool renamed_ = false;
};

// The rename itself reaches the disk with its folder. File systems that cannot do this lose nothing
// but the promise about a power cut, so a failure is no reason to refuse the result.
void FlushFolder(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int descriptor =
      open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

void WriteFileAtomically(const std::string& path, std::string_view contents) {
  if (path.empty()) throw std::invalid_argument("WriteFileAtomically: empty path");
  PartialFile file(path);
  file.Write(contents);
  file.Rename();
  FlushFolder(path);
}

std::string ReadFile(const std::string& path) {
  const auto fail = [&path](int error) {
    throw InputError(fmt::format("cannot read {}: {}", path, std::strerror(error)));
  };
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rb"),
                                                             &std::fclose);
  if (!file) fail(errno);
  std::string contents;
  std::array<char, 65536> buffer;
  while (const size_t count = std::fread(buffer.data(), 1, buffer.size(), file.get()))
    contents.append(buffer.data(), count);
  if (std::ferror(file.get()) != 0) fail(errno);
  return contents;
}

}  // namespace orient
