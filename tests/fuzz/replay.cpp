// CTest `fuzz_corpus`: runs every reader on the inputs kept for it.
//
//   fuzz_corpus CORPUS             all of them
//   fuzz_corpus FILE READER        one input; prints the message to the user
//   fuzz_corpus --list             the names of the readers
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <filesystem>

#include "core/base/atomic_write.h"
#include "tests/fuzz/reader.h"

namespace orient::fuzz {
namespace {

// Contents of a file, on disk or in an archive.
std::string Contents(const std::string& path) {
  VSILFILE* file = VSIFOpenL(path.c_str(), "rb");
  Require(file != nullptr, path + " cannot be read");
  VSIFSeekL(file, 0, SEEK_END);
  std::string contents(VSIFTellL(file), '\0');
  VSIRewindL(file);
  Require(VSIFReadL(contents.data(), 1, contents.size(), file) == contents.size(), path);
  VSIFCloseL(file);
  return contents;
}

// Returns the message to the user.
std::string Run(const Reader& reader, const std::string& path) {
  const std::string contents = Contents(path);
  // On the heap with its exact size, so that a sanitizer detects reads beyond the end.
  const std::vector<std::uint8_t> bytes(contents.begin(), contents.end());
  try {
    reader(bytes);
  } catch (const InputError& error) {
    return error.what();
  } catch (const std::exception& error) {
    Require(false, path + ": " + error.what());
  }
  return "taken";
}

// Returns the number of inputs.
int RunAll(const Reader& reader, const std::string& folder) {
  const CPLStringList names(VSIReadDir(folder.c_str()));
  int inputs = 0;
  for (int i = 0; i < names.size(); ++i) {
    if (names[i][0] == '.') continue;
    Run(reader, folder + "/" + names[i]);
    ++inputs;
  }
  return inputs;
}

int Main(const std::vector<std::string>& words) {
  if (words.size() == 1 && words[0] == "--list") {
    for (const auto& [name, reader] : Readers()) std::puts(name.c_str());
    return 0;
  }
  if (words.size() == 2) {
    std::puts(Run(Readers().at(words[1]), words[0]).c_str());
    return 0;
  }
  for (const auto& [name, reader] : Readers()) {
    const auto start = std::chrono::steady_clock::now();
    const std::string folder = words.at(0) + "/" + name;
    const int inputs = RunAll(reader, folder) + RunAll(reader, "/vsizip/" + folder + ".zip");
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    fmt::print("{}: {} inputs, {:.2f} s\n", name, inputs, seconds.count());
    Require(inputs > 0, folder + " has no inputs");
  }
  return 0;
}

}  // namespace
}  // namespace orient::fuzz

int main(int argc, char** argv) {
  return orient::fuzz::Main(std::vector<std::string>(argv + 1, argv + argc));
}
