#include "core/base/column_names.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <set>
#include <string_view>

#include "core/base/remote_files.h"

namespace orient {
namespace {

const std::map<std::string, std::string>& Synonyms() {
  static const std::map<std::string, std::string> synonyms = {
      {"easting", "x"}, {"east", "x"},       {"x/easting", "x"}, {"northing", "y"},
      {"north", "y"},   {"y/northing", "y"}, {"height", "z"},    {"altitude", "z"},
      {"alt", "z"},     {"z/altitude", "z"}, {"z/height", "z"},  {"elevation", "z"},
      {"o", "omega"},   {"p", "phi"},        {"k", "kappa"},     {"x0", "x"},
      {"y0", "y"},      {"z0", "z"},         {"sx", "sigma_x"},  {"sy", "sigma_y"},
      {"sz", "sigma_z"}};
  return synonyms;
}

std::string Lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "x [m]", "omega(deg)" without the unit, if it is the unit of Orient's tables.
std::string WithoutUnit(const std::string& name) {
  static constexpr std::array<std::string_view, 6> kUnits = {"[m]",   "(m)",      "[deg]",
                                                             "(deg)", "[degree]", "(degree)"};
  for (const std::string_view unit : kUnits)
    if (name.ends_with(unit)) {
      const std::string bare = name.substr(0, name.size() - unit.size());
      return bare.substr(0, bare.find_last_not_of(' ') + 1);
    }
  return name;
}

// "omega [gon]", "yaw_deg" -> "omega", "yaw".
std::string FirstWord(const std::string& name) {
  return name.substr(0, name.find_first_of("[(_ "));
}

}  // namespace

std::string ColumnName(const std::string& written) {
  const std::string name = WithoutUnit(Lower(written));
  const auto known = Synonyms().find(name);
  return known == Synonyms().end() ? name : known->second;
}

std::string ColumnOfOtherUnit(const std::string& written) {
  // Without brackets only these: "height_above_ground" is no height in another unit.
  static const std::set<std::string> units = {"ft",  "feet", "usft", "km",  "m",
                                              "gon", "grad", "rad",  "deg", "degrees"};
  const std::string name = Lower(written);
  const std::size_t end = name.find_first_of("[(_ ");
  if (end == std::string::npos) return "";
  const std::size_t unit = name.find_first_not_of(" _", end);
  if (unit == std::string::npos) return "";
  if (name[unit] != '[' && name[unit] != '(' && !units.contains(name.substr(unit))) return "";
  return ColumnName(FirstWord(name));
}

bool NamesAngle(const std::string& written) {
  static const std::set<std::string> angles = {"omega",   "phi",  "kappa", "yaw",
                                               "heading", "roll", "pitch", "azimuth"};
  return angles.contains(FirstWord(Lower(written))) || angles.contains(ColumnOfOtherUnit(written));
}

std::map<std::string, std::size_t> ColumnPlaces(const std::vector<std::string>& written,
                                                std::optional<std::size_t>* twice) {
  constexpr std::array kPhoto = {"filename",  "photo", "photoid", "image",
                                 "imagename", "label", "name",    "id"};
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < written.size(); ++i)
    if (!places.emplace(ColumnName(written[i]), i).second && !*twice) *twice = i;
  for (const char* name : kPhoto)
    if (const auto place = places.find(name); place != places.end())
      places.emplace("filename", place->second);
  return places;
}

std::string WithoutImageEnding(const std::string& given) {
  const bool of_windows = given.starts_with("\\\\") || given.find(":\\") == 1;
  const std::string name = of_windows ? given.substr(given.rfind('\\') + 1) : given;
  static const std::set<std::string> endings = {
      ".tif", ".tiff", ".jpg", ".jpeg", ".png", ".jp2", ".j2k",  ".jpx",  ".jxl", ".img", ".bmp",
      ".gif", ".ecw",  ".sid", ".vrt",  ".dng", ".ntf", ".nitf", ".webp", ".pix", ".pgm", ".ppm"};
  if (!endings.contains(Lower(std::filesystem::path(name).extension().string()))) return name;
  return std::filesystem::path(IsRemote(name) ? WithoutEscapes(name) : name).stem().string();
}

std::string BareImageName(const std::string& image) {
  const std::string path = IsRemote(image) ? WithoutEscapes(image) : image;
  return WithoutImageEnding(std::filesystem::path(path).filename().string());
}

}  // namespace orient
