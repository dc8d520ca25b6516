// orient cameras new: a camera file from scans on which a person clicked the fiducial marks.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "block/roll/new_camera.h"
#include "core/measurements/measurements.h"
#include "tools/commands/command.h"
#include "tools/commands/shared_options.h"

namespace CLI {
class App;
}

namespace orient {

// Nested in `orient cameras`.
class NewCameraCommand {
 public:
  void Setup(CLI::App& cameras);
  bool Asked() const;
  // Throws UsageError, InputError.
  ExitCode Run(std::ostream& out) const;

 private:
  void AddTableOptions();
  std::vector<block::ClickedScan> Scans() const;
  block::NewCameraOptions Options() const;
  std::vector<std::string> Inputs() const;  // files that are read

  CLI::App* app_ = nullptr;
  std::vector<std::string> scans_, clicks_;
  std::vector<double> frame_mm_;
  std::string out_, name_, positions_, distances_, scanner_ = "desktop";
  Measurements measurements_;
  ScanOptions scan_;
  double principal_distance_mm_ = 0, template_radius_mm_ = 2;
  bool overwrite_ = false;
};

}  // namespace orient
