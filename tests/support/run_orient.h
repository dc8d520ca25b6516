// Runs the program `orient` within the test's process, with the arguments a user would type.
#pragma once

#include <sstream>
#include <string>
#include <vector>

#include "tools/commands/commands.h"

namespace orient {

struct ProgramRun {
  int exit_code = 0;
  std::string out, err;
};

inline ProgramRun RunOrient(const std::vector<std::string>& arguments) {
  std::ostringstream out, err;
  const int code = RunProgram(MakeCommands(), arguments, out, err);
  return {code, out.str(), err.str()};
}

}  // namespace orient
