#include "core/exchange/micmac_orientation.h"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/base/output_directory.h"
#include "core/exchange/text_lines.h"
#include "core/exchange/xml_elements.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr const char* kConvention = "eConvApero_DistM2C";
constexpr double kTolerance_px = 0.001;

std::string Numbers(const Eigen::Ref<const Eigen::VectorXd>& v) {
  std::vector<std::string> texts;
  for (const double value : v) texts.push_back(ExactNumber(value));
  return fmt::format("{}", fmt::join(texts, " "));
}

std::string Tag(int depth, const std::string& name, const std::string& content) {
  return fmt::format("{0:{1}}<{2}>{3}</{2}>\n", "", 5 * depth, name, content);
}

std::string Group(int depth, const std::string& name, const std::string& content) {
  return fmt::format("{0:{1}}<{2}>\n{3}{0:{1}}</{2}>\n", "", 5 * depth, name, content);
}

std::string Document(const std::string& content) {
  return "<?xml version=\"1.0\" ?>\n" + Group(0, "ExportAPERO", content);
}

// AutoCal_Foc-<focal length in micrometres>_Cam-<name>: letters and digits only.
std::string CalibrationName(const ExchangeBlock& block, std::size_t i) {
  const ExchangeCamera& camera = block.cameras[i];
  std::string name =
      fmt::format("AutoCal_Foc-{}_Cam-", std::lround(camera.focal_px.x() * camera.pixel_mm * 1000));
  for (const char c : camera.name)
    name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  if (block.cameras.size() > 1) name += fmt::format("_{}", i + 1);
  return name;
}

std::string CalibrationText(const ExchangeCamera& camera) {
  const double f = camera.focal_px.x();
  const Eigen::Vector2d pp = camera.principal_px - Eigen::Vector2d(0.5, 0.5);
  std::string radial = Tag(5, "CDist", Numbers(pp));
  for (int i = 0; i < 3; ++i)
    radial += Tag(5, "CoeffDist",
                  ExactNumber(camera.k[static_cast<std::size_t>(i)] / std::pow(f, 2 * (i + 1))));
  radial += Tag(5, "PPaEqPPs", "true");
  std::string model = Group(4, "RadialePart", radial);
  model += Tag(4, "P1", ExactNumber(camera.p[0] / f)) + Tag(4, "P2", ExactNumber(camera.p[1] / f));
  model += Tag(4, "b1", "0") + Tag(4, "b2", "0");
  std::string text = Tag(2, "KnownConv", kConvention) + Tag(2, "PP", Numbers(pp));
  text += Tag(2, "F", ExactNumber(f));
  text += Tag(2, "SzIm", fmt::format("{} {}", camera.width, camera.height));
  text += Group(2, "CalibDistortion", Group(3, "ModPhgrStd", model));
  return Document(Group(1, "CalibrationInternConique", text));
}

std::string VerifText(const ExchangeBlock& block, std::size_t photo) {
  std::string points;
  int number = 0;
  for (const VerificationPoint& check : block.verification) {
    if (check.photo != photo) continue;
    const Eigen::Vector2d pixel = check.pixel - Eigen::Vector2d(0.5, 0.5);
    points += Group(3, "Appuis",
                    Tag(4, "Num", std::to_string(number++)) + Tag(4, "Im", Numbers(pixel)) +
                        Tag(4, "Ter", Numbers(check.ground)));
  }
  if (points.empty()) return "";
  return Group(2, "Verif",
               Tag(3, "Tol", ExactNumber(kTolerance_px)) + Tag(3, "ShowMes", "true") + points);
}

// Mean ground height and depth, which MicMac needs, from the photo's own verification points.
std::string GroundText(const ExchangeBlock& block, std::size_t photo) {
  double height = 0, depth = 0;
  int count = 0;
  const ExchangePhoto& p = block.photos[photo];
  for (const VerificationPoint& check : block.verification) {
    if (check.photo != photo) continue;
    height += check.ground.z();
    depth += (GroundFromCamera(p).transpose() * (check.ground - p.centre)).z();
    ++count;
  }
  if (count == 0) return "";
  return Tag(3, "AltiSol", ExactNumber(height / count)) +
         Tag(3, "Profondeur", ExactNumber(depth / count));
}

std::string OrientationText(const ExchangeBlock& block, std::size_t i,
                            const std::string& calibration) {
  const ExchangePhoto& photo = block.photos[i];
  const Eigen::Matrix3d r = GroundFromCamera(photo);
  std::string matrix;
  for (int row = 0; row < 3; ++row)
    matrix += Tag(5, "L" + std::to_string(row + 1), Numbers(r.row(row).transpose()));
  std::string outer = GroundText(block, i) + Tag(3, "KnownConv", kConvention);
  outer += Tag(3, "Centre", Numbers(photo.centre)) + Tag(3, "IncCentre", "1 1 1");
  outer += Group(3, "ParamRotation", Group(4, "CodageMatr", matrix));
  std::string text =
      Group(2, "OrIntImaM2C", Tag(3, "I00", "0 0") + Tag(3, "V10", "1 0") + Tag(3, "V01", "0 1"));
  text += Tag(2, "TypeProj", "eProjStenope") + Tag(2, "ZoneUtileInPixel", "true");
  text += Tag(2, "FileInterne", XmlEscaped(calibration)) + Tag(2, "RelativeNameFI", "true");
  text += Group(2, "Externe", outer) + VerifText(block, i);
  text += Group(2, "ConvOri", Tag(3, "KnownConv", kConvention));
  return Document(Group(1, "OrientationConique", text));
}

Eigen::Vector2d Vector2(const XmlElement& e) { return Eigen::Vector2d(e.Numbers(2).data()); }
Eigen::Vector3d Vector3(const XmlElement& e) { return Eigen::Vector3d(e.Numbers(3).data()); }

void RequireConvention(const XmlElement& element) {
  const XmlElement* convention = element.Find("KnownConv");
  if (convention != nullptr && convention->text != kConvention)
    throw InputError(fmt::format("{} is \"{}\"; only {} is known", convention->Where(),
                                 convention->text, kConvention));
}

void ReadRadial(const XmlElement& radial, MicmacCalibration* calibration) {
  calibration->centre = Vector2(radial.At("CDist"));
  for (const XmlElement* c : radial.All("CoeffDist")) calibration->radial.push_back(c->Number());
  for (std::size_t i = 3; i < calibration->radial.size(); ++i)
    if (calibration->radial[i] != 0)
      throw InputError(
          fmt::format("{} has more than three coefficients; only the first three are supported",
                      radial.Where()));
}

MicmacCalibration ReadCalibration(const std::string& path) {
  const XmlElement root = ReadXml(path);
  const XmlElement* element =
      root.name == "CalibrationInternConique" ? &root : root.Below("CalibrationInternConique");
  if (element == nullptr) throw InputError(path + " holds no <CalibrationInternConique>");
  RequireConvention(*element);
  MicmacCalibration calibration;
  calibration.name = fs::path(path).stem().string();
  calibration.pp = Vector2(element->At("PP"));
  calibration.f = element->At("F").Number();
  const XmlElement& size = element->At("SzIm");
  for (int i = 0; i < 2; ++i)
    calibration.size[i] = WholeNumber(Vector2(size)[i], size.Where(), "a size");
  calibration.centre = calibration.pp;
  for (const XmlElement* distortion : element->All("CalibDistortion"))
    for (const XmlElement& model : distortion->children) {
      if (model.name == "ModRad") {
        ReadRadial(model, &calibration);
      } else if (model.name == "ModPhgrStd") {
        ReadRadial(model.At("RadialePart"), &calibration);
        for (const char* b : {"b1", "b2"})
          if (const XmlElement* affine = model.Find(b); affine != nullptr && affine->Number() != 0)
            throw InputError(affine->Where() + ": an affine part is not supported");
        if (const XmlElement* p = model.Find("P1")) calibration.p1 = p->Number();
        if (const XmlElement* p = model.Find("P2")) calibration.p2 = p->Number();
      } else if (model.name != "ModNoDist") {
        throw InputError(model.Where() +
                         ": this distortion is not supported; supported are ModNoDist, " +
                         "ModRad and ModPhgrStd");
      }
    }
  return calibration;
}

MicmacOrientation ReadOrientation(const XmlElement& root, const std::string& image) {
  const XmlElement* element =
      root.name == "OrientationConique" ? &root : root.Below("OrientationConique");
  if (element == nullptr) throw InputError(root.Where() + " holds no <OrientationConique>");
  const XmlElement& outer = element->At("Externe");
  RequireConvention(outer);
  if (const XmlElement* convention = element->Find("ConvOri")) RequireConvention(*convention);
  MicmacOrientation orientation;
  orientation.image = image;
  orientation.centre = Vector3(outer.At("Centre"));
  const XmlElement& matrix = outer.At("ParamRotation").At("CodageMatr");
  for (int row = 0; row < 3; ++row)
    orientation.rotation.row(row) = Vector3(matrix.At("L" + std::to_string(row + 1)));
  if (const XmlElement* verif = element->Find("Verif"))
    for (const XmlElement* point : verif->All("Appuis"))
      orientation.checks.push_back({Vector2(point->At("Im")), Vector3(point->At("Ter"))});
  return orientation;
}

std::vector<std::string> OrientationFiles(const std::string& directory) {
  auto files = FilesNamed(directory, "Orientation-", ".xml");
  if (!files.empty()) return files;
  std::vector<std::string> found;
  for (const std::string& folder : FilesNamed(directory, "Ori-", ""))
    if (fs::is_directory(folder))
      for (const std::string& file : FilesNamed(folder, "Orientation-", ".xml"))
        found.push_back(file);
  if (found.empty()) throw InputError(directory + " holds no Orientation-*.xml");
  if (fs::path(found.front()).parent_path() != fs::path(found.back()).parent_path())
    throw InputError(directory + " holds several Ori-... folders; name one of them");
  return found;
}

}  // namespace

void WriteMicmacOrientation(const std::string& directory, const std::string& name,
                            const ExchangeBlock& block) {
  const fs::path folder = fs::path(directory) / ("Ori-" + name);
  MakeOutputDirectory(folder.string());
  for (std::size_t i = 0; i < block.cameras.size(); ++i) {
    const ExchangeCamera& camera = block.cameras[i];
    if (std::abs(camera.focal_px.x() / camera.focal_px.y() - 1) > 1e-12)
      throw InputError("the camera '" + camera.name +
                       "' has no square pixels, as MicMac's files require; resample its " +
                       "images with --images");
    WriteFileAtomically((folder / (CalibrationName(block, i) + ".xml")).string(),
                        CalibrationText(camera));
  }
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const std::string calibration =
        fmt::format("Ori-{}/{}.xml", name, CalibrationName(block, block.photos[i].camera));
    WriteFileAtomically(
        (folder / ("Orientation-" + fs::path(block.photos[i].image).filename().string() + ".xml"))
            .string(),
        OrientationText(block, i, calibration));
  }
}

MicmacFolder ReadMicmacOrientation(const std::string& directory) {
  MicmacFolder folder;
  std::map<std::string, std::size_t> index;  // of calibrations
  for (const std::string& path : OrientationFiles(directory)) {
    const std::string file = fs::path(path).filename().string();
    const std::string begins = "Orientation-", ends = ".xml";
    const XmlElement root = ReadXml(path);
    MicmacOrientation orientation = ReadOrientation(
        root, file.substr(begins.size(), file.size() - begins.size() - ends.size()));
    const XmlElement* internal = root.Below("FileInterne");
    if (internal == nullptr)
      throw InputError(path + " lacks <FileInterne>: its calibration must be in a separate file");
    const std::string calibration =
        (fs::path(path).parent_path() / fs::path(internal->text).filename()).string();
    const auto known = index.find(calibration);
    if (known == index.end()) {
      folder.calibrations.push_back(ReadCalibration(calibration));
      index[calibration] = folder.calibrations.size() - 1;
    }
    orientation.calibration = index.at(calibration);
    folder.orientations.push_back(std::move(orientation));
  }
  return folder;
}

ExchangeBlock ExchangeFromMicmac(const MicmacFolder& folder) {
  ExchangeBlock block;
  for (const MicmacCalibration& calibration : folder.calibrations) {
    if ((calibration.centre - calibration.pp).norm() > 1e-9)
      throw InputError(calibration.name +
                       ".xml: CDist differs from PP: a distortion centre other than the " +
                       "principal point is not supported");
    ExchangeCamera camera;
    camera.name = calibration.name;
    camera.width = calibration.size.x();
    camera.height = calibration.size.y();
    camera.focal_px.setConstant(calibration.f);
    camera.principal_px = calibration.pp + Eigen::Vector2d(0.5, 0.5);
    for (std::size_t i = 0; i < 3 && i < calibration.radial.size(); ++i)
      camera.k[i] = calibration.radial[i] * std::pow(calibration.f, 2 * (static_cast<int>(i) + 1));
    camera.p = {calibration.p1 * calibration.f, calibration.p2 * calibration.f};
    block.cameras.push_back(camera);
  }
  for (const MicmacOrientation& orientation : folder.orientations) {
    ExchangePhoto photo;
    photo.image = orientation.image;
    photo.camera = orientation.calibration;
    photo.centre = orientation.centre;
    SetGroundFromCamera(orientation.rotation, &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
