// --earth, which several subcommands have.
#pragma once

#include <CLI/App.hpp>
#include <string>

#include "core/terrain/earth_effects.h"

namespace orient {

inline CLI::Option* AddEarthOption(CLI::App& app, EarthMode* mode) {
  return app
      .add_option_function<std::string>(
          "--earth", [mode](const std::string& name) { *mode = EarthModes().at(name); },
          "Earth curvature and refraction: auto (where they exceed 0.1 px), flat (without) or "
          "curved (with them)")
      ->check(CLI::IsMember({"auto", "flat", "curved"}))
      ->default_str("auto");
}

}  // namespace orient
