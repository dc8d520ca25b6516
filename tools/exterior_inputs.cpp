#include "tools/exterior_inputs.h"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/files/atomic_write.h"

namespace orient {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

std::string PathIn(const std::string& directory) {
  return (fs::path(directory) / "exterior_inputs.json").string();
}

}  // namespace

void WriteExteriorInputs(const std::string& directory, const ExteriorInputs& inputs) {
  const Json json = {{"camera", inputs.camera},
                     {"dem", inputs.dem},
                     {"options", inputs.options},
                     {"added_earth_k1", inputs.added_earth_k1}};
  WriteFileAtomically(PathIn(directory), json.dump(2) + "\n");
}

std::optional<ExteriorInputs> ReadExteriorInputs(const std::string& directory) {
  const std::string path = PathIn(directory);
  if (!fs::exists(path)) return std::nullopt;
  try {
    const Json json = Json::parse(ReadFile(path));
    if (!json.contains("added_earth_k1"))
      throw InputError(path + " is damaged, or of another version of Orient; leave --resume out " +
                       "and give --overwrite");
    return ExteriorInputs{json.at("camera").get<std::string>(), json.at("dem").get<std::string>(),
                          json.at("options").get<std::string>(),
                          json.at("added_earth_k1").get<double>()};
  } catch (const Json::exception& error) {
    throw InputError(path +
                     " is damaged; leave --resume out and give --overwrite: " + error.what());
  }
}

void RequireSameInputs(const std::string& directory, const ExteriorInputs& then,
                       const ExteriorInputs& now) {
  std::string what;
  if (then.camera != now.camera) what = "camera file";
  if (then.dem != now.dem) what += what.empty() ? "DEM" : ", DEM";
  if (then.options != now.options)
    what +=
        (what.empty() ? "" : ", ") + ("options (" + then.options + "; now " + now.options + ")");
  if (what.empty()) return;
  throw InputError("the results in " + directory + " were made with another " + what +
                   "; repeat all of them with --overwrite instead of --resume, or name another " +
                   "folder with --out");
}

}  // namespace orient
