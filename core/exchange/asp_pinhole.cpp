#include "core/exchange/asp_pinhole.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/terrain/geocentric.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

// A priori sigma of control: of the ground (m) and of an observation (px).
constexpr double kGroundSigma_m = 1, kPixelSigma = 1;

std::string Line(const std::string& key, const std::vector<double>& values) {
  std::string text = key + " =";
  for (const double value : values) {
    text += ' ';
    text += ExactNumber(value);
  }
  return text + "\n";
}

std::string TsaiText(const ExchangeCamera& camera, const ExchangePhoto& photo) {
  const double pitch = camera.pixel_mm;
  const Eigen::Vector2d f = pitch * camera.focal_px;
  const Eigen::Vector2d c = pitch * (camera.principal_px - Eigen::Vector2d(0.5, 0.5));
  const Eigen::Matrix3d r = GroundFromCamera(photo);
  std::string text = "VERSION_4\nPINHOLE\n";
  text += Line("fu", {f.x()}) + Line("fv", {f.y()}) + Line("cu", {c.x()}) + Line("cv", {c.y()});
  text += "u_direction = 1 0 0\nv_direction = 0 1 0\nw_direction = 0 0 1\n";
  text += Line("C", {photo.centre.x(), photo.centre.y(), photo.centre.z()});
  text +=
      Line("R", {r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)});
  text += Line("pitch", {pitch});
  if (!camera.HasDistortion()) return text + "NULL\n";
  text += "TSAI\n" + Line("k1", {camera.k[0]}) + Line("k2", {camera.k[1]});
  text += Line("p1", {camera.p[1]}) + Line("p2", {camera.p[0]});
  if (camera.k[2] != 0) text += Line("k3", {camera.k[2]});
  return text;
}

std::string GcpText(const ExchangeBlock& block) {
  std::string text;
  int id = 0;
  for (const ExchangePoint& point : block.points) {
    if (!point.control) continue;
    const Geodetic at = GeodeticFromGeocentric(point.ground);
    text += std::to_string(id++);
    for (const double value : {DegFromRad(at.latitude_rad), DegFromRad(at.longitude_rad),
                               at.height_m, kGroundSigma_m, kGroundSigma_m, kGroundSigma_m}) {
      text += ' ';
      text += ExactNumber(value);
    }
    for (const ExchangeObservation& seen : point.observations) {
      text += " " + block.photos[seen.photo].image;
      for (const double value :
           {seen.pixel.x() - 0.5, seen.pixel.y() - 0.5, kPixelSigma, kPixelSigma}) {
        text += ' ';
        text += ExactNumber(value);
      }
    }
    text += '\n';
  }
  return text;
}

// The lines "key = numbers", and the words of lines that hold one word only.
struct TsaiLines {
  std::string file;
  std::map<std::string, TextLine> values;
  std::vector<std::string> words;

  double Number(const std::string& key) const { return At(key).Number(2, key); }
  double NumberOr0(const std::string& key) const { return values.contains(key) ? Number(key) : 0; }
  Eigen::Vector3d Vector(const std::string& key, std::size_t from = 0) const {
    return {At(key).Number(2 + from, key), At(key).Number(3 + from, key),
            At(key).Number(4 + from, key)};
  }
  const TextLine& At(const std::string& key) const {
    const auto found = values.find(key);
    if (found == values.end()) throw InputError(file + " lacks the line \"" + key + " = ...\"");
    return found->second;
  }
};

TsaiLines ReadLines(const std::string& path) {
  TsaiLines lines;
  lines.file = path;
  for (const TextLine& line : ReadTextLines(path)) {
    if (line.Size() == 1) {
      lines.words.push_back(line.Word(0, "a word"));
    } else if (line.Word(1, "=") == "=") {
      lines.values.emplace(line.Word(0, "a key"), line);
    } else {
      line.Fail("\"" + line.Word(0, "a key") + "\" is not followed by =");
    }
  }
  return lines;
}

AspPinhole ReadOne(const std::string& path) {
  const TsaiLines lines = ReadLines(path);
  if (lines.words.size() < 2 || lines.words[1] != "PINHOLE")
    throw InputError(path + " is not a pinhole camera: its second line must be PINHOLE");
  AspPinhole pinhole;
  pinhole.image = fs::path(path).stem().string();
  pinhole.fu = lines.Number("fu");
  pinhole.fv = lines.Number("fv");
  pinhole.cu = lines.Number("cu");
  pinhole.cv = lines.Number("cv");
  pinhole.pitch = lines.Number("pitch");
  pinhole.uvw = {lines.Vector("u_direction"), lines.Vector("v_direction"),
                 lines.Vector("w_direction")};
  pinhole.c = lines.Vector("C");
  for (int row = 0; row < 3; ++row)
    pinhole.r.row(row) = lines.Vector("R", static_cast<std::size_t>(3 * row));
  const std::string model = lines.words.size() > 2 ? lines.words[2] : "NULL";
  if (model == "TSAI") {
    pinhole.k1 = lines.Number("k1");
    pinhole.k2 = lines.Number("k2");
    pinhole.p1 = lines.Number("p1");
    pinhole.p2 = lines.Number("p2");
    pinhole.k3 = lines.NumberOr0("k3");
  } else if (model != "NULL") {
    throw InputError(path + ": the distortion " + model +
                     " is not supported; supported are NULL and " +
                     "TSAI (convert_pinhole_model makes one)");
  }
  return pinhole;
}

}  // namespace

void WriteAsp(const std::string& directory, const ExchangeBlock& block) {
  const bool control = std::any_of(block.points.begin(), block.points.end(),
                                   [](const ExchangePoint& point) { return point.control; });
  for (const ExchangePhoto& photo : block.photos)
    WriteFileAtomically((fs::path(directory) / (BareImageName(photo.image) + ".tsai")).string(),
                        TsaiText(block.cameras[photo.camera], photo));
  if (control) WriteFileAtomically((fs::path(directory) / "control.gcp").string(), GcpText(block));
}

std::vector<AspPinhole> ReadAsp(const std::string& path) {
  if (!fs::is_directory(path)) return {ReadOne(path)};
  std::vector<AspPinhole> photos;
  for (const std::string& file : FilesNamed(path, "", ".tsai")) photos.push_back(ReadOne(file));
  if (photos.empty()) throw InputError(path + " holds no .tsai file");
  return photos;
}

ExchangeBlock ExchangeFromAsp(const std::vector<AspPinhole>& photos) {
  ExchangeBlock block;
  for (const AspPinhole& p : photos) {
    ExchangeCamera camera;
    camera.name = p.image;
    camera.pixel_mm = p.pitch;
    camera.focal_px = Eigen::Vector2d(p.fu, p.fv) / p.pitch;
    camera.principal_px = Eigen::Vector2d(p.cu, p.cv) / p.pitch + Eigen::Vector2d(0.5, 0.5);
    camera.k = {p.k1, p.k2, p.k3};
    camera.p = {p.p2, p.p1};
    block.cameras.push_back(camera);
    ExchangePhoto photo;
    photo.image = p.image;
    photo.camera = block.photos.size();
    photo.centre = p.c;
    Eigen::Matrix3d axes;
    axes << p.uvw[0], p.uvw[1], p.uvw[2];
    SetGroundFromCamera(p.r * axes, &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
