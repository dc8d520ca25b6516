// What a command leaves in its output folder about itself: run.json, which the report shows.
#pragma once

#include <ctime>
#include <string>
#include <vector>

#include "tools/report/run_record.h"

namespace orient {

// How the program was called.
struct Invocation {
  std::string program, command;
  std::vector<std::string> arguments;  // after the program's name
  std::time_t started = 0;
};

// A file among the inputs; no path: none was given.
RunInput FileInput(const std::string& what, const std::string& path);
// Of a folder of patch databases its index.
RunInput PatchesInput(const std::string& patchdb);
RunInput RasterInput(const std::string& what, const std::string& path);

// Inputs without a path are left out. Where the file cannot be written there is none: no result
// depends on it.
void RecordRun(const Invocation& invocation, const std::string& directory, const std::string& stage,
               const std::vector<RunInput>& inputs);

}  // namespace orient
