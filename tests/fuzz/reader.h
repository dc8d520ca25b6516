// Readers that are given any bytes: each .cpp file of this folder registers one or a few. With
// libFuzzer (preset `fuzz`) they are the program `orient_fuzz`, which runs the reader that
// $ORIENT_READER names; with any compiler `fuzz_corpus`, which runs all of them on the inputs that
// are kept in corpus/<reader>/ and corpus/<reader>.zip.
//
// A reader ends well or throws InputError. Whatever else happens is a finding: another exception, a
// signal, what a sanitizer says, a broken Require, too much memory or time.
#pragma once

#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"

namespace orient::fuzz {

using Input = std::span<const std::uint8_t>;
using Reader = std::function<void(Input)>;

std::map<std::string, Reader>& Readers();

struct Register {
  Register(const std::string& name, Reader reader) { Readers()[name] = std::move(reader); }
};

inline std::string_view Text(Input input) {
  return {reinterpret_cast<const char*>(input.data()), input.size()};
}

// A folder of this process, removed at its end.
const std::string& Folder();
// A file in it (or in a folder below it) that holds `contents`; its path.
std::string FileWith(const std::string& name, std::string_view contents);
// The same in GDAL's memory; `contents` must stay.
std::string MemoryFileWith(const std::string& name, Input contents);

// The parts of an input that stands for several files, between lines "====".
std::vector<std::string_view> Parts(Input input);

// Empty where the reader refuses.
template <typename Read>
auto Accepted(const Read& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// Ends the process where something is not as it must be.
void Require(bool holds, const std::string& what);

// Values out of an input, one after the other; zeros when it is used up.
class Values {
 public:
  explicit Values(Input input) : rest_(input) {}

  template <typename T>
  T Take() {
    T value{};
    const Input bytes = Bytes(sizeof(T));
    std::memcpy(&value, bytes.data(), bytes.size());
    return value;
  }
  // 0 .. `count` - 1.
  std::size_t Below(std::size_t count) { return Take<std::uint8_t>() % count; }
  Input Bytes(std::size_t count) {
    const Input bytes = rest_.first(std::min(count, rest_.size()));
    rest_ = rest_.subspan(bytes.size());
    return bytes;
  }
  Input Rest() const { return rest_; }

 private:
  Input rest_;
};

}  // namespace orient::fuzz
