#include "core/exchange/measured_columns.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <set>
#include <utility>

#include "core/base/column_names.h"

namespace orient {
namespace {

// Meanings of the column names that are unambiguous.
const std::map<std::string, std::string>& Meanings() {
  static const std::map<std::string, std::string> meanings = [] {
    const std::vector<std::pair<std::string, std::vector<std::string>>> names = {
        {"photo",
         {"photo", "image", "filename", "file", "img", "image_name", "photo_name", "file_name",
          "camera_label"}},
        {"point",
         {"point", "marker", "gcp", "point_name", "point_id", "gcp_name", "gcp_label", "gcp_id",
          "marker_name", "marker_label"}},
        {"col", {"col", "column", "px", "u", "pixel_x", "x_px", "im_x", "image_x", "pixel_col"}},
        {"row", {"row", "py", "v", "pixel_y", "y_px", "im_y", "image_y", "pixel_row"}},
        {"x_mm", {"x_mm"}},
        {"y_mm", {"y_mm"}},
        {"x", {"x", "e", "geo_x", "x_m"}},
        {"y", {"y", "n", "geo_y", "y_m"}},
        {"z", {"z", "h", "geo_z", "z_m"}},
        {"sigma", {"sigma", "accuracy", "std", "stdev", "sd"}},
        {"sigma_px", {"sigma_px", "accuracy_px"}},
        {"sigma_mm", {"sigma_mm", "accuracy_mm"}},
        {"sigma_m", {"sigma_m", "accuracy_m"}},
        {"enabled", {"enabled"}},
        {"sigma_x", {"sigma_x", "accuracy_x", "x_accuracy"}},
        {"sigma_y", {"sigma_y", "accuracy_y", "y_accuracy"}},
        {"sigma_z", {"sigma_z", "accuracy_z", "z_accuracy", "vertical_accuracy"}},
        {"sigma_xy", {"sigma_xy", "accuracy_xy", "sxy", "horizontal_accuracy"}},
        {"role", {"role", "type", "use", "kind"}},
        {"geographic", {"lat", "latitude", "lon", "long", "longitude", "lng"}}};
    std::map<std::string, std::string> all;
    for (const auto& [meaning, written] : names)
      for (const std::string& name : written) all[name] = meaning;
    return all;
  }();
  return meanings;
}

// "Image Name" -> "image_name", "x [mm]" -> "x_mm", "Easting (m)" -> "x".
std::string Plain(const std::string& written) {
  std::string plain;
  for (const char c : ColumnName(written)) {
    const bool letter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '/';
    if (letter)
      plain += c;
    else if (!plain.empty() && plain.back() != '_')
      plain += '_';
  }
  while (plain.ends_with('_')) plain.pop_back();
  return plain;
}

// Assigns ambiguous names (name, label, id) to meanings that still have no column.
class OpenNames {
 public:
  OpenNames(const std::vector<std::string>& plain, MeasuredColumns* columns) : columns_(*columns) {
    for (const char* name : {"name", "label", "id"})
      if (const auto at = std::find(plain.begin(), plain.end(), name); at != plain.end())
        open_.emplace_back(name, static_cast<std::size_t>(at - plain.begin()));
  }

  // Assigns the first of these names that is still free, if `meaning` has no column yet.
  void Give(const std::string& meaning, const std::vector<std::string>& names) {
    if (columns_.Has(meaning)) return;
    for (const std::string& name : names)
      for (auto open = open_.begin(); open != open_.end(); ++open)
        if (open->first == name) {
          columns_.places[meaning] = open->second;
          open_.erase(open);
          return;
        }
  }

 private:
  MeasuredColumns& columns_;
  std::vector<std::pair<std::string, std::size_t>> open_;
};

void Rename(const std::string& from, const std::string& to, MeasuredColumns* columns) {
  columns->places[to] = columns->places.at(from);
  columns->places.erase(from);
}

// Why a pair of columns cannot be used; "" if both of its halves are present or neither is.
std::string WhyHalf(const MeasuredColumns& columns) {
  constexpr std::array<std::pair<const char*, const char*>, 2> kPairs = {
      {{"col", "row"}, {"x_mm", "y_mm"}}};
  for (const auto& [one, other] : kPairs)
    if (columns.Has(one) != columns.Has(other))
      return fmt::format("there is a column of {} and none of {}", columns.Has(one) ? one : other,
                         columns.Has(one) ? other : one);
  if (columns.Has("col") && columns.Has("x_mm"))
    return "image coordinates are there in pixels and in millimetres; keep one of them";
  return "";
}

// Whether the columns are named exactly "x" and "y", without z: not eastings, not metres.
bool AreOfImages(const std::vector<std::string>& plain, const MeasuredColumns& columns) {
  const auto said = [&](const char* meaning) {
    return columns.Has(meaning) && plain[columns.places.at(meaning)] == meaning;
  };
  return !columns.InPixels() && !columns.Has("x_mm") && !columns.Has("z") && said("x") && said("y");
}

// For a table with columns of image coordinates or photos, or with x and no z.
void SettleImagePoints(const std::vector<std::string>& plain, MeasuredColumns* columns) {
  if (AreOfImages(plain, *columns)) {
    Rename("x", "col", columns);
    Rename("y", "row", columns);
    columns->perhaps_mm = true;
  }
  OpenNames open(plain, columns);
  open.Give("photo", {"name", "label"});
  open.Give("point", {"id", "label", "name"});
  columns->image_points = columns->Has("photo") && columns->Has("point") &&
                          (columns->InPixels() || columns->Has("x_mm"));
}

void SettleGroundPoints(const std::vector<std::string>& plain, MeasuredColumns* columns) {
  if (!columns->image_points) OpenNames(plain, columns).Give("point", {"name", "id", "label"});
  columns->ground_points =
      columns->Has("point") && columns->Has("x") && columns->Has("y") && columns->Has("z");
}

// Why a unit in the name of a sigma column does not fit the coordinates; "" if it does.
std::string SettleSigma(MeasuredColumns* columns) {
  const bool pixels = columns->image_points && columns->InPixels();
  const bool millimetres = columns->image_points && !columns->InPixels();
  const std::pair<const char*, bool> units[] = {
      {"sigma_px", pixels}, {"sigma_mm", millimetres}, {"sigma_m", columns->ground_points}};
  for (const auto& [name, fits] : units) {
    if (!columns->Has(name)) continue;
    if (!fits)
      return fmt::format(
          "the accuracies are in {}, and the coordinates are not; give them in the "
          "coordinates' unit",
          std::string(name).substr(6));
    const bool of_ground_beside = std::string(name) == "sigma_m" && columns->image_points;
    const char* meaning = of_ground_beside ? "sigma_ground" : "sigma";
    if (columns->Has(meaning)) return fmt::format("two columns mean {}; keep one of them", meaning);
    Rename(name, meaning, columns);
  }
  return "";
}

std::string WhyNot(const MeasuredColumns& columns) {
  if (columns.image_points || columns.ground_points) return "";
  return "the header names neither image points (columns photo, point, col, row or photo, point, "
         "x_mm, y_mm) nor ground points (point, x, y, z); name the columns so";
}

}  // namespace

MeasuredColumns MeasuredColumnsOf(const std::vector<std::string>& header) {
  MeasuredColumns columns;
  std::vector<std::string> plain;
  std::string twice;
  for (std::size_t i = 0; i < header.size(); ++i) {
    plain.push_back(Plain(header[i]));
    const auto meaning = Meanings().find(plain.back());
    if (meaning == Meanings().end()) continue;
    if (!columns.places.emplace(meaning->second, i).second && meaning->second != "geographic")
      twice = fmt::format("two columns mean {} (\"{}\" and \"{}\"); keep one of them",
                          meaning->second, header[columns.places.at(meaning->second)], header[i]);
  }
  const bool geographic = columns.Has("geographic");
  columns.places.erase("geographic");
  const std::string half = WhyHalf(columns);
  const bool plane = columns.Has("x") && !columns.Has("z");
  if (columns.Has("photo") || columns.InPixels() || columns.Has("x_mm") || plane)
    SettleImagePoints(plain, &columns);
  SettleGroundPoints(plain, &columns);
  columns.why_not = WhyNot(columns);
  if (columns.why_not.empty()) columns.why_not = SettleSigma(&columns);
  if (columns.why_not.empty() && columns.Has("role") && columns.Has("enabled"))
    columns.places.erase("enabled");
  if (!half.empty()) columns.why_not = half;
  if (!twice.empty()) columns.why_not = twice;
  const auto has = [&](const char* name) {
    return std::find(plain.begin(), plain.end(), name) != plain.end();
  };
  if (has("omega") || has("kappa") || has("yaw"))
    columns.why_not =
        "this is a table of photos' orientations (omega, phi, kappa or yaw), not of points; give "
        "it as --approximations";
  if (geographic && !(columns.ground_points || columns.image_points))
    columns.why_not =
        "the coordinates are geographic (latitude and longitude); transform them to the block's "
        "CRS, in metres, and name the columns x, y, z";
  std::set<std::size_t> read;
  for (const auto& [meaning, place] : columns.places) read.insert(place);
  for (std::size_t i = 0; i < header.size(); ++i)
    if (!read.contains(i)) columns.unread.push_back(header[i]);
  return columns;
}

}  // namespace orient
