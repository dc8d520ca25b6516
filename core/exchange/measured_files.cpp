#include "core/exchange/measured_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <stdexcept>

#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/exchange/frame_measures.h"
#include "core/exchange/measured_tables.h"
#include "core/exchange/metashape_measures.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

using Eigen::Vector2d;
using Eigen::Vector3d;

// All elements of this name, the root among them, in document order.
void Collect(const XmlElement& element, const std::string& name,
             std::vector<const XmlElement*>* found) {
  if (element.name == name) found->push_back(&element);
  for (const XmlElement& child : element.children) Collect(child, name, found);
}

std::vector<const XmlElement*> AllNamed(const XmlElement& root, const std::string& name) {
  std::vector<const XmlElement*> found;
  Collect(root, name, &found);
  return found;
}

void AddMicmacImage(const XmlElement& image, const MeasuredSigma& sigma,
                    GatheredMeasurements* all) {
  const XmlElement& name = image.At("NameIm");
  if (name.text == "Glob" || name.text.find('*') != std::string::npos)
    throw InputError(fmt::format(
        "{} is \"{}\", no image: these are marks of the camera (MeasuresCamera.xml), in mm; give "
        "the images' own files (MeasuresIm-...)",
        name.Where(), name.text));
  for (const XmlElement* seen : image.All("OneMesureAF1I")) {
    const std::vector<double> at = seen->At("PtIm").Numbers(2);
    all->Add(seen->Where(),
             ImagePointMeasurement{WithoutImageEnding(fs::path(name.text).filename().string()),
                                   seen->At("NamePt").text, Vector2d(at[0] + 0.5, at[1] + 0.5),
                                   std::nullopt, *sigma.image});
  }
}

// MicMac gives a point with negative uncertainty no weight: it becomes a check point.
void AddMicmacPoint(const XmlElement& given, const MeasuredSigma& sigma,
                    GatheredMeasurements* all) {
  const std::vector<double> at = given.At("Pt").Numbers(3);
  const XmlElement* stated = given.Find("Incertitude");
  const std::vector<double> own =
      stated ? stated->Numbers(3) : std::vector<double>(3, sigma.ground_m);
  const auto unused = std::count_if(own.begin(), own.end(), [](double one) { return one <= 0; });
  if (unused == 1 || unused == 2)
    throw InputError(fmt::format(
        "{} is \"{}\": only some of the point's coordinates are used; give all three an "
        "uncertainty, or none (a check point)",
        stated->Where(), stated->text));
  all->Add(given.Where(), GroundPoint{given.At("NamePt").text, Vector3d(at[0], at[1], at[2]),
                                      unused > 0 ? Vector3d(Vector3d::Constant(sigma.ground_m))
                                                 : Vector3d(own[0], own[1], own[2]),
                                      unused > 0 ? PointRole::kCheck : PointRole::kControl});
}

void AddMicmac(const std::string& path, const MeasuredSigma& sigma, GatheredMeasurements* all) {
  const XmlElement root = ReadXml(path);
  for (const XmlElement* image : AllNamed(root, "MesureAppuiFlottant1Im"))
    AddMicmacImage(*image, sigma, all);
  for (const XmlElement* given : AllNamed(root, "OneAppuisDAF")) AddMicmacPoint(*given, sigma, all);
}

constexpr std::array<const char*, 5> kNames = {"metashape", "micmac", "patb", "bingo", "csv"};

void AddOfFormat(const std::string& path, MeasuredFormat format, const MeasuredSigma& sigma,
                 GatheredMeasurements* all) {
  switch (format) {
    case MeasuredFormat::kMetashape:
      return AddMetashapeMarkers(path, sigma, all);
    case MeasuredFormat::kMicmac:
      return AddMicmac(path, sigma, all);
    case MeasuredFormat::kPatb:
      return AddPatbMeasures(path, sigma, all);
    case MeasuredFormat::kBingo:
      return AddBingoMeasures(path, sigma, all);
    case MeasuredFormat::kCsv:
      return AddMeasuredTable(path, sigma, all);
  }
}

}  // namespace

std::optional<MeasuredFormat> MeasuredFormatFromName(const std::string& name) {
  for (std::size_t i = 0; i < kNames.size(); ++i)
    if (name == kNames.at(i)) return static_cast<MeasuredFormat>(i);
  return std::nullopt;
}

void AddMeasuredFile(const std::string& path, MeasuredFormat format, const MeasuredSigma& sigma,
                     GatheredMeasurements* all) {
  if (format != MeasuredFormat::kCsv && !sigma.image)
    throw std::invalid_argument("AddMeasuredFile: no accuracy of image coordinates");
  const std::size_t before = all->Found(), notes = all->Notes().size();
  AddOfFormat(path, format, sigma, all);
  if (all->Found() > before) return;
  std::string why = fmt::format("{} holds no measured point that can be used as {}", path,
                                kNames.at(static_cast<std::size_t>(format)));
  for (std::size_t i = notes; i < all->Notes().size(); ++i) why += "; " + all->Notes()[i];
  throw InputError(why + "; is it a file of that program's measurements?");
}

}  // namespace orient
