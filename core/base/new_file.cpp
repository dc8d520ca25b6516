#include "core/base/new_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <utility>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/partial_files.h"

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
    case ENAMETOOLONG:
      return "; use a shorter name";
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

// It would be replaced by a file, /dev/stdout too.
void RefuseDevice(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  const bool other = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status) &&
                     !std::filesystem::is_directory(status);
  if (other || std::filesystem::absolute(path, error).parent_path() == "/dev")
    throw InputError("cannot write " + path + ": it is a pipe or a device; name a file");
}

// A rename is on disk only after its folder is flushed. If the file system cannot do this, only the
// safety in a power cut is lost, so a failure is no reason to refuse the result.
void FlushFolder(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  const int descriptor =
      open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

NewFile::NewFile(std::string target) : target_(std::move(target)) {
  RefuseDevice(target_);
  for (int attempt = 0;; ++attempt) {
    partial_ = PartialName(target_, attempt);
    descriptor_ = open(partial_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) return;
    if (errno != EEXIST) FailToWrite(target_, errno);
  }
}

NewFile::~NewFile() {
  if (descriptor_ >= 0) close(descriptor_);
  if (!kept_) unlink(partial_.c_str());
}

void NewFile::Write(std::string_view contents) {
  while (!contents.empty()) {
    const ssize_t written = write(descriptor_, contents.data(), contents.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) FailToWrite(target_, errno);
    contents.remove_prefix(static_cast<std::size_t>(written));
  }
}

void NewFile::Flush() {
  faults_.ThrowIfAny();
  if (close(std::exchange(descriptor_, -1)) != 0) FailToWrite(target_, errno);
  // Opened by name: a library may have replaced the file that was opened.
  descriptor_ = open(partial_.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor_ < 0) FailToWrite(target_, errno);
  if (fsync(descriptor_) != 0 && errno != EINVAL) FailToWrite(target_, errno);
  if (close(std::exchange(descriptor_, -1)) != 0) FailToWrite(target_, errno);
}

void NewFile::Keep() {
  Flush();
  if (rename(partial_.c_str(), target_.c_str()) != 0) FailToWrite(target_, errno);
  kept_ = true;
  FlushFolder(target_);
}

void NewFile::KeepAsNew() {
  Flush();
  int error =
      renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, target_.c_str(), RENAME_NOREPLACE) == 0
          ? 0
          : errno;
  if (error == EINVAL || error == ENOSYS)  // not supported by the file system
    error = access(target_.c_str(), F_OK) == 0               ? EEXIST
            : rename(partial_.c_str(), target_.c_str()) == 0 ? 0
                                                             : errno;
  if (error == EEXIST)
    throw InputError(target_ + " exists already; give another name or delete it first");
  if (error != 0) FailToWrite(target_, error);
  kept_ = true;
  FlushFolder(target_);
}

void NewFile::Fail(const std::string& why) const {
  faults_.ThrowIfAny();
  throw InputError(fmt::format("cannot write {}: {}", target_, why));
}

}  // namespace orient
