// Readers fed with arbitrary bytes; the .cpp files of this folder register one or more each. With
// libFuzzer (preset `fuzz`), they form the program `orient_fuzz`, which runs the reader named by
// $ORIENT_READER; with any compiler, `fuzz_corpus`, which runs all of them on the inputs kept in
// corpus/<reader>/ and corpus/<reader>.zip.
//
// A reader succeeds or throws InputError. Anything else is a finding: another exception, a signal,
// a sanitizer report, a failed Require, too much memory or time.
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
// Writes `contents` to a file in that folder (or in a folder below it); returns its path.
std::string FileWith(const std::string& name, std::string_view contents);
// The same in GDAL's memory; `contents` must outlive its use.
std::string MemoryFileWith(const std::string& name, Input contents);

// The parts of an input that represents several files, separated by lines "====".
std::vector<std::string_view> Parts(Input input);

// Empty if the reader rejects the input.
template <typename Read>
auto Accepted(const Read& read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const InputError&) {
    return std::nullopt;
  }
}

// Aborts the process if `holds` is false.
void Require(bool holds, const std::string& what);

// Takes values from an input, one after the other; zeros once it is used up.
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
