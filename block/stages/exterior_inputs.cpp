#include "block/stages/exterior_inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "block/inputs/digest.h"
#include "block/inputs/measurement_inputs.h"
#include "core/base/error.h"

namespace orient::block {
namespace {

std::string NumberOrDash(const std::optional<double>& value) {
  return value ? fmt::format("{:.9g}", *value) : "-";
}

std::string ValueIn(const Inputs& inputs, const std::string& name) {
  const auto found = inputs.find(name);
  return found == inputs.end() ? "unknown" : found->second;
}

// Accuracy of approximations without sigmas, and the accuracy required of the result.
std::string AccuracyText(const ExteriorRunOptions& options) {
  std::string text = "position " + NumberOrDash(options.position_sigma_m) + " m, attitude " +
                     NumberOrDash(options.attitude_sigma_rad) + " rad";
  if (options.kappa_sigma_rad) text += ", kappa " + NumberOrDash(options.kappa_sigma_rad) + " rad";
  if (options.target_m) text += ", target " + NumberOrDash(options.target_m) + " m";
  return text + (options.accuracy_is_stated ? "" : ", not vouched for");
}

}  // namespace

ResultStore ExteriorStore(const std::string& directory) { return {directory, ".exterior.json"}; }

Inputs InputsOfRun(const ExteriorRunOptions& options) {
  return {{"camera", DigestOfCamera(ReadCameraFile(options.camera))},
          {"dem", DigestOfRaster(options.dem)},
          {"options", "earth " + Name(options.earth) + ", principal distance sigma " +
                          NumberOrDash(options.principal_distance_sigma_mm) + " mm"}};
}

std::vector<std::string> OwnResultsFirst(const ResultStore& results,
                                         const std::vector<std::string>& paths) {
  std::vector<std::string> own;
  for (const std::string& path : paths) {
    const auto then = results.MadeFrom(PhotoName(path));
    if (then && !then->empty()) own.push_back(PhotoName(path));
  }
  return own.empty() ? results.Jobs() : own;
}

void RequireSameInputs(const ResultStore& results, const std::vector<std::string>& photos,
                       const Inputs& of_run) {
  for (const std::string& photo : photos) {
    const auto then = results.MadeFrom(photo);
    if (!then || then->empty()) continue;
    std::vector<std::string> changed = WhatChanged(*then, of_run);
    std::erase_if(changed, [&](const std::string& name) { return !of_run.contains(name); });
    if (changed.empty()) continue;
    std::string what = TextOfInputs(changed);
    if (std::find(changed.begin(), changed.end(), "options") != changed.end())
      what += " (" + ValueIn(*then, "options") + "; now " + ValueIn(of_run, "options") + ")";
    throw InputError(
        fmt::format("the results in {}, for example that of {}, were made with other inputs ({}); "
                    "repeat all of them with --overwrite instead of --resume, or name another "
                    "folder with --out",
                    results.Folder(), photo, what));
  }
}

std::optional<double> EarthK1Of(const ResultStore& results,
                                const std::vector<std::string>& photos) {
  for (const std::string& photo : photos) try {
      const auto k1 = ReadExteriorResult(results.PathOf(photo)).earth_k1;
      if (k1) return k1;
    } catch (const InputError&) {  // done again, if it is this run's
    }
  return std::nullopt;
}

Inputs InputsOfPhoto(const ExteriorRunOptions& options, const OrientationTable& approximations,
                     const std::string& path) {
  const std::string name = PhotoName(path);
  Inputs inputs = options.inputs;
  inputs["scan"] = DigestOfFile(path);
  inputs["approximation"] = Digest(TextOf(approximations.Find(name)));
  inputs["accuracy"] = AccuracyText(options);
  AddMeasurements(TextOfPoints(options.measurements, name), &inputs);
  if (options.interior)
    inputs["interior"] = DigestOfContents(InteriorResultPath(*options.interior, name));
  return inputs;
}

}  // namespace orient::block
