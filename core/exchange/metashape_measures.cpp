#include "core/exchange/metashape_measures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {

double NumberIn(const XmlElement& element, const std::string& key) {
  return ParseNumber(element.Attribute(key), element.Where(), key);
}

// "1" or "true", "0" or "false", depending on the version; `absent` if the attribute is missing.
bool Flag(const XmlElement& element, const std::string& key, bool absent) {
  const auto said = element.attributes.find(key);
  if (said == element.attributes.end()) return absent;
  if (said->second == "1" || said->second == "true") return true;
  if (said->second == "0" || said->second == "false") return false;
  throw InputError(fmt::format("{}: {} is \"{}\"; it must be 1, 0, true or false", element.Where(),
                               key, said->second));
}

// All descendants of this name, in document order, but none within another one of that name.
std::vector<const XmlElement*> AllBelow(const XmlElement& element, const std::string& name) {
  std::vector<const XmlElement*> found;
  for (const XmlElement& child : element.children) {
    if (child.name == name) {
      found.push_back(&child);
      continue;
    }
    const auto below = AllBelow(child, name);
    found.insert(found.end(), below.begin(), below.end());
  }
  return found;
}

// A camera's label is usually its file name, perhaps with folders.
std::string PhotoOfLabel(const std::string& label) {
  return WithoutImageEnding(label.substr(label.find_last_of("/\\") + 1));
}

// Those with an id: frames hold further elements called `camera` and `marker`.
std::vector<const XmlElement*> Listed(const XmlElement& chunk, const std::string& name) {
  std::vector<const XmlElement*> listed;
  for (const XmlElement* element : AllBelow(chunk, name))
    if (element->attributes.contains("id")) listed.push_back(element);
  return listed;
}

// One chunk of a document; resolves the ids of its cameras and markers.
class Chunk {
 public:
  Chunk(const XmlElement& chunk, const MeasuredSigma& sigma, GatheredMeasurements* all)
      : chunk_(chunk), sigma_(sigma), all_(*all) {
    for (const XmlElement* camera : Listed(chunk, "camera"))
      AddId(*camera, PhotoOfLabel(camera->Attribute("label")), &photos_);
    for (const XmlElement* marker : Listed(chunk, "marker"))
      AddId(*marker, marker->Attribute("label"), &markers_);
  }

  void AddGround() const {
    for (const XmlElement* marker : Listed(chunk_, "marker"))
      if (const XmlElement* given = marker->Find("reference");
          given != nullptr && given->attributes.contains("x"))
        AddPoint(marker->Attribute("label"), *given);
  }

  // Returns how many locations were left out as not measured: those not valid, those not pinned.
  std::array<int, 2> AddLocations() {
    std::array<int, 2> left_out = {0, 0};
    const XmlElement* frame_of_first = nullptr;
    auto frames = AllBelow(chunk_, "frame");
    if (frames.empty()) frames.push_back(&chunk_);
    for (const XmlElement* frame : frames)
      for (const XmlElement* marker : AllBelow(*frame, "marker")) {
        if (!marker->attributes.contains("marker_id")) continue;
        for (const XmlElement* seen : marker->All("location")) {
          const bool valid = Flag(*seen, "valid", true);
          if (!valid || !Flag(*seen, "pinned", true)) {
            ++left_out[valid ? 1 : 0];
            continue;
          }
          RequireOneFrame(*seen, frame, &frame_of_first);
          AddLocation(*marker, *seen);
        }
      }
    return left_out;
  }

 private:
  using Names = std::map<std::string, std::string>;  // by id

  static void AddId(const XmlElement& element, const std::string& name, Names* names) {
    if (!names->emplace(element.Attribute("id"), name).second)
      throw InputError(fmt::format("{}: the id {} is another {}'s of this chunk, too",
                                   element.Where(), element.Attribute("id"), element.name));
  }

  const std::string& NameOf(const Names& names, const XmlElement& element,
                            const std::string& key) const {
    const auto found = names.find(element.Attribute(key));
    if (found != names.end()) return found->second;
    const std::string what = key.substr(0, key.find('_'));
    throw InputError(fmt::format("{}: its chunk has no {} with the {} {}", element.Where(), what,
                                 key, element.Attribute(key)));
  }

  // In a chunk of several frames one camera label stands for several photos.
  void RequireOneFrame(const XmlElement& seen, const XmlElement* frame,
                       const XmlElement** first) const {
    if (*first == nullptr) *first = frame;
    if (frame != *first)
      throw InputError(
          seen.Where() +
          ": the chunk has locations in several frames, which are different photos of one name; "
          "export the markers of each frame by itself");
  }

  void AddLocation(const XmlElement& marker, const XmlElement& seen) {
    const std::string& photo = NameOf(photos_, seen, "camera_id");
    const auto [camera, is_new] = camera_of_.try_emplace(photo, seen.Attribute("camera_id"));
    if (!is_new && camera->second != seen.Attribute("camera_id"))
      throw InputError(fmt::format(
          "{}: two cameras of its chunk are called {}; give them different labels in Metashape",
          seen.Where(), photo));
    all_.Add(seen.Where(),
             ImagePointMeasurement{photo, NameOf(markers_, marker, "marker_id"),
                                   Eigen::Vector2d{NumberIn(seen, "x"), NumberIn(seen, "y")},
                                   std::nullopt, *sigma_.image});
  }

  // WKT that names no projection, also below a compound system: "COMPD_CS[...,GEOGCS[...",...".
  static bool IsUnprojected(const std::string& wkt) {
    constexpr std::array<const char*, 5> kUnprojected = {"GEOGCS", "GEOGCRS", "GEODCRS", "GEOCCS",
                                                         "GEODETICCRS"};
    if (wkt.find("PROJ") != std::string::npos) return false;
    return std::any_of(kUnprojected.begin(), kUnprojected.end(),
                       [&](const char* name) { return wkt.find(name) != std::string::npos; });
  }

  void RequireMetric(const XmlElement& given) const {
    for (const char* name : {"reference", "marker_crs", "coordinate_system"}) {
      const XmlElement* system = chunk_.Find(name);
      if (system == nullptr) continue;
      const bool degrees = std::abs(NumberIn(given, "x")) <= 180 &&
                           std::abs(NumberIn(given, "y")) <= 90 && system->text.starts_with("EPSG");
      if (degrees || IsUnprojected(system->text))
        throw InputError(fmt::format(
            "{}: the markers' coordinates are geographic or geocentric ({}), not in metres of a "
            "projected system; convert them to the block's CRS in Metashape (Reference pane > "
            "Convert Reference) and export again",
            given.Where(), system->text.substr(0, 40)));
    }
  }

  double SigmaOf(const XmlElement& given, char axis) const {
    for (const std::string& key :
         {std::string("s") + axis, std::string(axis == 'z' ? "sz" : "sxy"), std::string("sxyz")})
      if (given.attributes.contains(key)) return NumberIn(given, key);
    return sigma_.ground_m;
  }

  void AddPoint(const std::string& name, const XmlElement& given) const {
    RequireMetric(given);
    GroundPoint point;
    point.name = name;
    point.ground_m = {NumberIn(given, "x"), NumberIn(given, "y"), NumberIn(given, "z")};
    for (int i = 0; i < 3; ++i) point.sigma_m[i] = SigmaOf(given, "xyz"[i]);
    if (!Flag(given, "enabled", true)) point.role = PointRole::kCheck;
    all_.Add(given.Where(), point);
  }

  const XmlElement& chunk_;
  const MeasuredSigma& sigma_;
  GatheredMeasurements& all_;
  Names photos_, markers_, camera_of_;
};

}  // namespace

void AddMetashapeMarkers(const std::string& path, const MeasuredSigma& sigma,
                         GatheredMeasurements* all) {
  const XmlElement root = ReadXml(path);
  std::vector<const XmlElement*> chunks = AllBelow(root, "chunk");
  if (chunks.empty()) chunks.push_back(&root);
  int invalid = 0, unpinned = 0;
  for (const XmlElement* element : chunks) {
    Chunk chunk(*element, sigma, all);
    chunk.AddGround();
    const auto left_out = chunk.AddLocations();
    invalid += left_out[0];
    unpinned += left_out[1];
  }
  if (invalid > 0)
    all->Note(
        fmt::format("{}: locations that are not valid in Metashape, left out: {}", path, invalid));
  if (unpinned > 0)
    all->Note(
        fmt::format("{}: locations that are not pinned (Metashape placed them, nobody measured "
                    "them), left out: {}; where they are right, pin them there and export again",
                    path, unpinned));
}

}  // namespace orient
