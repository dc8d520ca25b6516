#include "core/exchange/measured_files.h"

#include <array>
#include <filesystem>
#include <map>

#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr const char* kEnd = "-99";

double NumberIn(const XmlElement& element, const std::string& key) {
  return ParseNumber(element.Attribute(key), element.Where(), key);
}

// All elements of this name below, in document order.
void Collect(const XmlElement& element, const std::string& name,
             std::vector<const XmlElement*>* found) {
  if (element.name == name) found->push_back(&element);
  for (const XmlElement& child : element.children) Collect(child, name, found);
}

std::vector<const XmlElement*> AllBelow(const XmlElement& root, const std::string& name) {
  std::vector<const XmlElement*> found;
  Collect(root, name, &found);
  return found;
}

void AddMetashape(const std::string& path, const MeasuredSigma& sigma, Measurements* all) {
  const XmlElement root = ReadXml(path);
  std::map<std::string, std::string> photos, markers;  // by id
  for (const XmlElement* camera : AllBelow(root, "camera"))
    photos[camera->Attribute("id")] = fs::path(camera->Attribute("label")).stem().string();
  for (const XmlElement* marker : AllBelow(root, "marker")) {
    if (!marker->attributes.contains("id")) continue;
    markers[marker->Attribute("id")] = marker->Attribute("label");
    const XmlElement* given = marker->Find("reference");
    if (!given || !given->attributes.contains("x")) continue;
    GroundPoint point;
    point.name = marker->Attribute("label");
    point.ground_m = {NumberIn(*given, "x"), NumberIn(*given, "y"), NumberIn(*given, "z")};
    for (int i = 0; i < 3; ++i) {
      const std::string key = std::string("s") + "xyz"[i];
      point.sigma_m[i] = given->attributes.contains(key) ? NumberIn(*given, key) : sigma.ground_m;
    }
    const auto enabled = given->attributes.find("enabled");
    if (enabled != given->attributes.end() &&
        (enabled->second == "0" || enabled->second == "false"))
      point.role = PointRole::kCheck;
    all->points.push_back(std::move(point));
  }
  for (const XmlElement* marker : AllBelow(root, "marker")) {
    if (!marker->attributes.contains("marker_id")) continue;
    const auto name = markers.find(marker->Attribute("marker_id"));
    if (name == markers.end())
      throw InputError(marker->Where() + ": there is no marker with this marker_id");
    for (const XmlElement* seen : marker->All("location")) {
      const auto photo = photos.find(seen->Attribute("camera_id"));
      if (photo == photos.end())
        throw InputError(seen->Where() + ": there is no camera with this camera_id");
      all->image_points.push_back({photo->second, name->second,
                                   Vector2d(NumberIn(*seen, "x"), NumberIn(*seen, "y")),
                                   std::nullopt, sigma.image});
    }
  }
}

void AddMicmac(const std::string& path, const MeasuredSigma& sigma, Measurements* all) {
  const XmlElement root = ReadXml(path);
  for (const XmlElement* image : AllBelow(root, "MesureAppuiFlottant1Im")) {
    const std::string photo = fs::path(image->At("NameIm").text).stem().string();
    for (const XmlElement* seen : image->All("OneMesureAF1I")) {
      const std::vector<double> at = seen->At("PtIm").Numbers(2);
      all->image_points.push_back({photo, seen->At("NamePt").text,
                                   Vector2d(at[0] + 0.5, at[1] + 0.5), std::nullopt, sigma.image});
    }
  }
  for (const XmlElement* given : AllBelow(root, "OneAppuisDAF")) {
    const std::vector<double> at = given->At("Pt").Numbers(3);
    const XmlElement* stated = given->Find("Incertitude");
    const std::vector<double> own =
        stated ? stated->Numbers(3) : std::vector<double>(3, sigma.ground_m);
    const bool check =
        own[0] <= 0 || own[1] <= 0 || own[2] <= 0;  // MicMac's control weighs nothing
    all->points.push_back(
        {given->At("NamePt").text, Vector3d(at[0], at[1], at[2]),
         check ? Vector3d::Constant(sigma.ground_m) : Vector3d(own[0], own[1], own[2]),
         check ? PointRole::kCheck : PointRole::kControl});
  }
}

Vector3d GroundIn(const TextLine& line, std::size_t first) {
  return {line.Number(first, "x"), line.Number(first + 1, "y"), line.Number(first + 2, "z")};
}

void AddPoint(const std::string& name, const Vector3d& ground_m, const MeasuredSigma& sigma,
              Measurements* all) {
  all->points.push_back({name, ground_m, Vector3d::Constant(sigma.ground_m), PointRole::kControl});
}

// Photo by photo: a heading, points, -99.
void AddImageCoordinates(const std::vector<TextLine>& lines, double mm, const MeasuredSigma& sigma,
                         Measurements* all) {
  std::string photo;
  for (const TextLine& line : lines) {
    const std::string& first = line.Word(0, "a photo's or a point's name");
    if (first == kEnd)
      photo.clear();
    else if (photo.empty())
      photo = first;
    else
      all->image_points.push_back({photo, first, std::nullopt,
                                   Vector2d(mm * line.Number(1, "x"), mm * line.Number(2, "y")),
                                   sigma.image});
  }
  if (!photo.empty()) lines.back().Fail("the points of photo " + photo + " are not ended by -99");
}

void AddPatb(const std::string& path, const MeasuredSigma& sigma, Measurements* all) {
  constexpr double kMicrometre_mm = 1e-3;
  const std::vector<TextLine> lines = ReadTextLines(path);
  // A photo's heading has its number and perhaps the principal distance.
  if (lines.empty() || lines.front().Size() < 4) {
    AddImageCoordinates(lines, kMicrometre_mm, sigma, all);
    return;
  }
  for (const TextLine& line : lines)
    if (line.Word(0, "a point's name") != kEnd)
      AddPoint(line.Word(0, "a point's name"), GroundIn(line, 1), sigma, all);
}

void AddBingo(const std::string& path, const MeasuredSigma& sigma, Measurements* all) {
  std::vector<TextLine> others;
  for (const TextLine& line : ReadTextLines(path)) {
    if (line.Word(0, "a record") == "CONT")
      AddPoint(line.Word(1, "a point's name"), GroundIn(line, 2), sigma, all);
    else
      others.push_back(line);
  }
  AddImageCoordinates(others, 1, sigma, all);
}

}  // namespace

std::optional<MeasuredFormat> MeasuredFormatFromName(const std::string& name) {
  constexpr std::array<const char*, 4> kNames = {"metashape", "micmac", "patb", "bingo"};
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames.at(i)) return static_cast<MeasuredFormat>(i);
  return std::nullopt;
}

void AddMeasuredFile(const std::string& path, MeasuredFormat format, const MeasuredSigma& sigma,
                     Measurements* measurements) {
  switch (format) {
    case MeasuredFormat::kMetashape:
      return AddMetashape(path, sigma, measurements);
    case MeasuredFormat::kMicmac:
      return AddMicmac(path, sigma, measurements);
    case MeasuredFormat::kPatb:
      return AddPatb(path, sigma, measurements);
    case MeasuredFormat::kBingo:
      return AddBingo(path, sigma, measurements);
  }
}

}  // namespace orient
