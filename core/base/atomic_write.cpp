#include "core/base/atomic_write.h"

#include <fmt/format.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <stdexcept>

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

std::string ReadFile(const std::string& path) {
  const auto fail = [&path](int error) {
    const std::string what = fmt::format("cannot read {}: {}", path, std::strerror(error));
    if (IsOfEnvironment(error)) throw EnvironmentError(what);
    throw InputError(what);
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
