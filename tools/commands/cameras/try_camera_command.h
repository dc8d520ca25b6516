// orient cameras try: a camera file's drawings held against a scan.
#pragma once

#include <iosfwd>
#include <string>

#include "core/measurements/measurements.h"
#include "tools/commands/command.h"
#include "tools/commands/shared_options.h"

namespace CLI {
class App;
}

namespace orient {

// Nested in `orient cameras`.
class TryCameraCommand {
 public:
  void Setup(CLI::App& cameras);
  bool Asked() const;
  // `library`: of the command above, where none of its own is given. Throws UsageError, InputError.
  ExitCode Run(const std::string& library, std::ostream& out) const;

 private:
  CLI::App* app_ = nullptr;
  std::string camera_, scan_path_, out_, library_;
  Measurements measurements_;
  ScanOptions scan_;
  bool overwrite_ = false;
};

}  // namespace orient
