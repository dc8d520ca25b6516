// Entry point for libFuzzer: one reader per process.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/reader.h"

namespace {

const orient::fuzz::Reader& Chosen() {
  const char* name = std::getenv("ORIENT_READER");
  const auto& readers = orient::fuzz::Readers();
  const auto chosen = readers.find(name == nullptr ? "" : name);
  if (chosen != readers.end()) return chosen->second;
  std::fprintf(stderr, "set ORIENT_READER to one of");
  for (const auto& [known, reader] : readers) std::fprintf(stderr, " %s", known.c_str());
  std::fprintf(stderr, "\n");
  std::exit(1);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const orient::fuzz::Reader& reader = Chosen();
  try {
    reader({data, size});
  } catch (const orient::InputError&) {  // reported to the user
  }
  return 0;
}
