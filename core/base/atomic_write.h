// Files appear whole or not at all.
#pragma once

#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <string_view>

namespace orient {

// Writes beside `path`, flushes to disk and renames. Throws InputError naming path and cause (a
// read-only folder), EnvironmentError where there is no space or the device fails.
void WriteFileAtomically(const std::string& path, std::string_view contents);

// Whole contents; throws InputError naming the path, EnvironmentError where the device fails.
std::string ReadFile(const std::string& path);

// The same piece by piece.
class FilePieces {
 public:
  explicit FilePieces(std::string path);
  // Empty at the end; valid until the next call.
  std::string_view Next();
  void Rewind() { std::rewind(file_.get()); }

 private:
  std::string path_;
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> file_;
  std::array<char, 65536> piece_;
};

}  // namespace orient
