#include "core/files/inputs.h"

#include "core/base/error.h"
#include "core/files/json_fields.h"

namespace orient {
namespace {

// The name that users know.
std::string Called(const std::string& name) {
  if (name == "camera") return "camera file";
  if (name == "dem") return "DEM";
  if (name == "crs") return "CRS";
  return name;
}

}  // namespace

std::vector<std::string> WhatChanged(const Inputs& then, const Inputs& now) {
  Inputs all = then;
  all.insert(now.begin(), now.end());
  std::vector<std::string> changed;
  for (const auto& [name, value] : all) {
    const auto before = then.find(name), after = now.find(name);
    if (before == then.end() || after == now.end() || before->second != after->second)
      changed.push_back(name);
  }
  return changed;
}

std::string TextOfInputs(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + Called(name);
  return text;
}

std::optional<Inputs> ReadMadeFrom(const std::string& path) {
  try {
    const Json json = ParseJsonFile(path);
    const JsonField root(json, path);
    Inputs inputs = root.FindTexts("made_from");
    // Recorded in another form than this version's: nothing to compare with.
    if (inputs.empty() && root.Find("made_from")) return std::nullopt;
    return inputs;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace orient
