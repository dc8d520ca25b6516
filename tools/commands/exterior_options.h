// What `orient exterior` is told of its photos, and `orient review` of a folder that it may do
// again.
#pragma once

#include <CLI/App.hpp>
#include <optional>
#include <string>
#include <vector>

#include "block/stages/exterior_setting.h"

namespace orient {

// --approximations, --patchdb, --interior and all that weighs them.
class ExteriorOptions {
 public:
  void Setup(CLI::App& app);

  const std::string& PatchDatabase() const { return options_.patchdb; }
  const std::optional<std::string>& Interior() const { return options_.interior; }

  // Whether the command line had any of them; after parsing.
  bool AnyTold() const;

  // Photos, camera, DEM and folder are still to be named. Throws UsageError where neither
  // approximations nor ground points are there.
  block::ExteriorRunOptions For(const Measurements& measurements) const;

 private:
  block::ExteriorRunOptions options_;
  std::vector<const CLI::Option*> asked_;
  std::optional<double> attitude_sigma_deg_, kappa_sigma_deg_;
};

// Throws UsageError where the run would replace, or make untrue, results that are in its folder and
// not its own: a table with other photos, what a block left there. `overwrite` allows it.
void RefuseToReplace(const block::ExteriorRunOptions& options, bool overwrite);

}  // namespace orient
