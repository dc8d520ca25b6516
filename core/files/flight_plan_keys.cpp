#include "core/files/flight_plan_keys.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/files/orientation_table.h"
#include "core/geometry/rotation.h"

namespace orient {
namespace {

std::optional<double> Azimuth(const TomlTable& table) {
  const auto degrees = table.FindNumber("azimuth_deg");
  if (!degrees) return std::nullopt;
  if (std::abs(*degrees) > 360) table.Fail("azimuth_deg", "must lie between -360 and 360");
  return RadFromDeg(*degrees);
}

// A photo that overlaps the next one completely would have no base.
double Share(const TomlTable& table, std::string_view key, double fallback) {
  const double share = table.FindNumber(key).value_or(fallback);
  if (share < 0 || share > 0.95) table.Fail(key, "must lie between 0 and 0.95");
  return share;
}

std::optional<Eigen::Vector2d> NextStrip(const TomlTable& table) {
  const auto word = table.FindText("next_strip");
  if (!word) return std::nullopt;
  static const std::map<std::string, Eigen::Vector2d> kDirections = {
      {"north", {0, 1}}, {"east", {1, 0}}, {"south", {0, -1}}, {"west", {-1, 0}}};
  const auto found = kDirections.find(*word);
  if (found == kDirections.end())
    table.Fail("next_strip", "is \"" + *word + "\"; it must be north, east, south or west");
  return found->second;
}

void ReadFlight(const TomlTable& root, FlightPlan* plan) {
  const auto table = root.FindTable("flight", {"overlap", "side_lap", "azimuth_deg", "next_strip",
                                               "back_and_forth", "flying_height_m", "scale"});
  if (!table) return;
  plan->overlap = Share(*table, "overlap", plan->overlap);
  plan->side_lap = Share(*table, "side_lap", plan->side_lap);
  plan->azimuth_rad = Azimuth(*table);
  plan->next_strip = NextStrip(*table);
  plan->back_and_forth = table->FindFlag("back_and_forth").value_or(plan->back_and_forth);
  if (table->Has("flying_height_m"))
    plan->flying_height_m = table->PositiveNumber("flying_height_m");
  if (table->Has("scale")) plan->scale = table->PositiveNumber("scale");
  if (plan->scale && plan->flying_height_m)
    table->Fail("scale", "and flying_height_m are alternatives; give one of them");
}

// The photos that one entry of a strip stands for, in their natural order.
std::vector<std::string> Expanded(const std::string& entry,
                                  const std::vector<std::string>& photos) {
  // Unchanged if there is such a photo: names may have dots ("1961.0182").
  if (std::find(photos.begin(), photos.end(), entry) != photos.end()) return {entry};
  if (entry.find_first_of("*?[") == std::string::npos) return {PhotoName(entry)};
  std::vector<std::string> found;
  for (const std::string& photo : photos)
    if (fnmatch(entry.c_str(), photo.c_str(), 0) == 0) found.push_back(photo);
  std::sort(found.begin(), found.end(), NaturallyLess);
  return found;
}

FlightStrip ReadStrip(const TomlTable& table, std::size_t number,
                      const std::vector<std::string>& photos) {
  FlightStrip strip;
  strip.name = table.FindText("name").value_or(std::to_string(number));
  strip.azimuth_rad = Azimuth(table);
  const auto entries = table.FindTexts("photos");
  if (!entries || entries->empty())
    table.Fail("photos", fmt::format("of strip {} must list its photos in the order of exposure, "
                                     "as in [\"0182\", \"0183\"] or [\"05_*\"]",
                                     strip.name));
  for (const std::string& entry : *entries) {
    const std::vector<std::string> names = Expanded(entry, photos);
    if (names.empty())
      table.Fail("photos", "of strip " + strip.name + ": no photo of the block is called " + entry);
    strip.photos.insert(strip.photos.end(), names.begin(), names.end());
  }
  if (table.FindFlag("reversed").value_or(false))
    std::reverse(strip.photos.begin(), strip.photos.end());
  return strip;
}

}  // namespace

FlightPlan ReadFlightPlan(const TomlTable& root, const std::vector<std::string>& photos) {
  FlightPlan plan;
  ReadFlight(root, &plan);
  std::map<std::string, std::string> strip_of;
  for (const TomlTable& table :
       root.Tables("strips", {"name", "photos", "reversed", "azimuth_deg"})) {
    FlightStrip strip = ReadStrip(table, plan.strips.size() + 1, photos);
    for (const std::string& photo : strip.photos) {
      const auto [other, is_new] = strip_of.emplace(photo, strip.name);
      if (!is_new)
        table.Fail("photos", fmt::format("of strip {}: photo {}{}; name it once", strip.name, photo,
                                         other->second == strip.name
                                             ? " is listed twice"
                                             : fmt::format(" is in strip {}, too", other->second)));
    }
    plan.strips.push_back(std::move(strip));
  }
  return plan;
}

}  // namespace orient
