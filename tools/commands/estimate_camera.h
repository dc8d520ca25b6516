// orient interior estimate-camera: the marks' positions from the photos themselves.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "tools/commands/command.h"

namespace CLI {
class App;
}

namespace orient {

// Nested in `orient interior`, whose own required options it switches off when it is asked for.
class EstimateCameraCommand {
 public:
  void Setup(CLI::App& interior);
  bool Asked() const;
  // Throws UsageError, InputError.
  ExitCode Run(std::ostream& out) const;

 private:
  CLI::App* app_ = nullptr;
  std::vector<std::string> directories_;
  std::string start_, out_, library_;
  std::string scanner_ = "auto";
  bool overwrite_ = false;
};

}  // namespace orient
