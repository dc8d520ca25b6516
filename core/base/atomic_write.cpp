#include "core/base/atomic_write.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/new_file.h"

namespace orient {

void WriteFileAtomically(const std::string& path, std::string_view contents) {
  if (path.empty()) throw std::invalid_argument("WriteFileAtomically: empty path");
  NewFile file(path);
  file.Write(contents);
  file.Keep();
}

namespace {

[[noreturn]] void CannotRead(const std::string& path, int error) {
  const std::string what = fmt::format("cannot read {}: {}", path, std::strerror(error));
  if (IsOfEnvironment(error)) throw EnvironmentError(what);
  throw InputError(what);
}

}  // namespace

FilePieces::FilePieces(std::string path)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), "rb"), &std::fclose) {
  if (!file_) CannotRead(path_, errno);
}

std::string_view FilePieces::Next() {
  const std::size_t count = std::fread(piece_.data(), 1, piece_.size(), file_.get());
  if (count == 0 && std::ferror(file_.get()) != 0) CannotRead(path_, errno);
  return {piece_.data(), count};
}

std::string ReadFile(const std::string& path) {
  FilePieces pieces(path);
  std::string contents;
  for (std::string_view piece = pieces.Next(); !piece.empty(); piece = pieces.Next())
    contents += piece;
  return contents;
}

}  // namespace orient
