#include "core/exchange/frame_adjustments.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "core/base/atomic_write.h"
#include "core/base/column_names.h"
#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/geometry/lens.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

constexpr double kGonPerRadian = 200 / std::numbers::pi;
constexpr int kColumns = 16;  // of a value in PAT-B's records

bool IsNumber(const std::string& name) {
  return !name.empty() && name.size() <= 9 && name.front() != '0' &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string NameOf(const ExchangePhoto& photo) { return BareImageName(photo.image); }

// With as many decimals as fit into sixteen columns that begin with a blank.
std::string Column(double value) {
  for (int decimals = 13; decimals > 5; --decimals) {
    const std::string text = fmt::format("{:{}.{}f}", value, kColumns, decimals);
    if (text.size() <= kColumns && text.front() == ' ') return text;
  }
  return fmt::format("{:{}.5f}", value, kColumns);
}

std::string NumbersText(const ExchangeBlock& block) {
  std::string text = "# number photo\n";
  for (std::size_t i = 0; i < block.photos.size(); ++i)
    text += fmt::format("{} {}\n", PhotoNumber(block, i), NameOf(block.photos[i]));
  return text;
}

double PrincipalDistance(const ExchangeCamera& camera) {
  return camera.focal_px.x() * camera.pixel_mm;
}

std::string PatbOrientation(const ExchangeBlock& block) {
  std::string text;
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const ExchangePhoto& photo = block.photos[i];
    const Eigen::Matrix3d& a = photo.ground_from_photo;
    text += fmt::format("{0:>{2}}{1:{2}.6f}", PhotoNumber(block, i),
                        PrincipalDistance(block.cameras[photo.camera]), kColumns);
    for (const double x : photo.centre) text += Column(x);
    text += '\n';
    for (const double x : {a(0, 0), a(0, 1), a(0, 2), a(1, 0), a(1, 1)}) text += Column(x);
    text += '\n';
    for (const double x : {a(1, 2), a(2, 0), a(2, 1), a(2, 2)}) text += Column(x);
    text += '\n';
  }
  return text;
}

std::string BingoOrientation(const ExchangeBlock& block) {
  std::string text;
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const ExchangePhoto& photo = block.photos[i];
    text += "ORIA " + PhotoNumber(block, i);
    for (const double x : photo.centre) {
      text += ' ';
      text += ExactNumber(x);
    }
    for (const double x : OpkFromRotation(photo.ground_from_photo)) {
      text += ' ';
      text += ExactNumber(x * kGonPerRadian);
    }
    text += '\n';
  }
  return text;
}

// Blanks separate the columns of a heading.
std::string OneWord(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

// Unique names for the block's cameras: BINGO identifies cameras by name.
std::vector<std::string> BingoNames(const ExchangeBlock& block) {
  std::vector<std::string> names;
  for (const ExchangeCamera& camera : block.cameras) {
    std::string name = OneWord(camera.name);
    while (std::find(names.begin(), names.end(), name) != names.end()) name += "_2";
    names.push_back(name);
  }
  return names;
}

// Photo by photo: a heading, its points scaled, -99.
std::string ImageCoordinates(const ExchangeBlock& block, double per_mm, bool patb) {
  std::vector<std::string> of_photo(block.photos.size());
  for (const ReducedPoint& point : ReducedPoints(block)) {
    std::string& text = of_photo[point.photo];
    text += fmt::format("{:>12} {:14.6f} {:14.6f}{}\n", point.point, per_mm * point.photo_mm.x(),
                        per_mm * point.photo_mm.y(), patb ? " 1" : "");
  }
  std::string text;
  const std::vector<std::string> names = BingoNames(block);
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const std::size_t camera = block.photos[i].camera;
    text +=
        fmt::format("{:>12} {}\n{}{:12}\n", PhotoNumber(block, i),
                    patb ? fmt::format("{:14.3f}", 1000 * PrincipalDistance(block.cameras[camera]))
                         : names[camera],
                    of_photo[i], -99);
  }
  return text;
}

std::string Control(const ExchangeBlock& block, bool patb) {
  std::string text;
  for (const ExchangePoint& point : block.points) {
    if (!point.control) continue;
    text += patb ? fmt::format("{:>12}", point.name) : "CONT " + point.name;
    for (const double x : point.ground) text += fmt::format(" {:14.4f}", x);
    text += patb ? " 1\n" : "\n";
  }
  return patb ? text + fmt::format("{:12}\n", -99) : text;
}

std::string InFolder(const std::string& path, const char* file) {
  return fs::is_directory(path) ? (fs::path(path) / file).string() : path;
}

std::string NamedBack(const std::string& number, const std::map<std::string, std::string>& names) {
  const auto found = names.find(number);
  return found == names.end() ? number : found->second;
}

}  // namespace

Eigen::Vector2d ReducedFromPixel(const ExchangeCamera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d from_principal = pixel - camera.principal_px;
  const double c = PrincipalDistance(camera);
  return {c * from_principal.x() / camera.focal_px.x(),
          -c * from_principal.y() / camera.focal_px.y()};
}

std::vector<ReducedPoint> ReducedPoints(const ExchangeBlock& block) {
  std::vector<Camera> cameras;
  for (const ExchangeCamera& camera : block.cameras) {
    if (camera.width <= 0 || camera.height <= 0)
      throw InputError("the camera '" + camera.name + "' has no image size; give it with --camera");
    cameras.push_back(CameraOf(camera));
  }
  std::vector<ReducedPoint> points;
  for (const ExchangePoint& point : block.points)
    for (const ExchangeObservation& seen : point.observations) {
      const std::size_t camera = block.photos[seen.photo].camera;
      const Eigen::Vector2d measured = ReducedFromPixel(block.cameras[camera], seen.pixel);
      const auto ideal = UndistortPoint(cameras[camera].lens, measured);
      if (ideal) points.push_back({seen.photo, point.name, *ideal});
    }
  return points;
}

std::string PhotoNumber(const ExchangeBlock& block, std::size_t photo) {
  // Names serve as numbers only if all are numeric: an index could be another photo's name.
  const bool numbered = std::all_of(block.photos.begin(), block.photos.end(),
                                    [](const ExchangePhoto& p) { return IsNumber(NameOf(p)); });
  return numbered ? NameOf(block.photos[photo]) : std::to_string(photo + 1);
}

void WritePatb(const std::string& directory, const ExchangeBlock& block) {
  const auto write = [&](const char* name, const std::string& text) {
    WriteFileAtomically((fs::path(directory) / name).string(), text);
  };
  write("patb.ori", PatbOrientation(block));
  write("patb.im", ImageCoordinates(block, 1000, true));
  write("patb.con", Control(block, true));
  write("photo_numbers.txt", NumbersText(block));
}

void WriteBingo(const std::string& directory, const ExchangeBlock& block) {
  const auto write = [&](const char* name, const std::string& text) {
    WriteFileAtomically((fs::path(directory) / name).string(), text);
  };
  write("itera.dat", BingoOrientation(block));
  write("image.dat", ImageCoordinates(block, 1, false));
  write("geoin.dat", Control(block, false));
  write("photo_numbers.txt", NumbersText(block));
}

void WriteOri(const std::string& directory, const ExchangeBlock& block) {
  std::string text =
      "# photo X Y Z omega phi kappa; metres, degrees; R = Rx(omega) Ry(phi) Rz(kappa)\n";
  for (const ExchangePhoto& photo : block.photos) {
    text += QuotedWord(NameOf(photo));
    const Eigen::Vector3d opk = OpkFromRotation(photo.ground_from_photo);
    for (const double x : {photo.centre.x(), photo.centre.y(), photo.centre.z(), DegFromRad(opk[0]),
                           DegFromRad(opk[1]), DegFromRad(opk[2])}) {
      text += ' ';
      text += ExactNumber(x);
    }
    text += '\n';
  }
  WriteFileAtomically((fs::path(directory) / "orientation.ori").string(), text);
}

namespace {

// Files give principal distances in millimetres or micrometres; none is several metres.
double InMillimetres(double principal_distance) {
  constexpr double kLongest_mm = 5000;
  return principal_distance > kLongest_mm ? principal_distance / 1000 : principal_distance;
}

}  // namespace

std::vector<PatbPhoto> ReadPatb(const std::string& path) {
  const std::string file = InFolder(path, "patb.ori");
  const auto lines = ReadTextLines(file);
  std::vector<PatbPhoto> photos;
  for (std::size_t i = 0; i < lines.size(); i += 3) {
    if (i + 2 >= lines.size())
      lines[i].Fail("this photo's records end early: each photo has three lines");
    PatbPhoto photo;
    photo.number = lines[i].Word(0, "the photo's number");
    // The principal distance's columns may be blank.
    const std::size_t x = lines[i].Size() >= 5 ? 2 : 1;
    if (x == 2)
      photo.principal_distance_mm = InMillimetres(lines[i].Number(1, "the principal distance"));
    for (std::size_t j = 0; j < 3; ++j)
      photo.centre[static_cast<int>(j)] = lines[i].Number(x + j, "a coordinate");
    std::vector<double> a;
    for (std::size_t j = 0; j < 5; ++j) a.push_back(lines[i + 1].Number(j, "a11 ... a22"));
    for (std::size_t j = 0; j < 4; ++j) a.push_back(lines[i + 2].Number(j, "a23 ... a33"));
    photo.matrix = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(a.data());
    const double off = (photo.matrix * photo.matrix.transpose() - Eigen::Matrix3d::Identity())
                           .cwiseAbs()
                           .maxCoeff();
    if (off > 1e-3) lines[i + 1].Fail("a11 ... a33 are not a rotation matrix");
    photos.push_back(photo);
  }
  if (photos.empty()) throw InputError(file + " holds no photo");
  return photos;
}

namespace {

// The camera of each photo, from the headings of image.dat beside the orientation, if it exists.
std::map<std::string, std::string> BingoCameras(const std::string& orientation) {
  const fs::path file = fs::path(orientation).parent_path() / "image.dat";
  std::map<std::string, std::string> cameras;
  if (!fs::exists(file)) return cameras;
  bool heading = true;
  for (const TextLine& line : ReadTextLines(file.string())) {
    if (heading && line.Size() > 1) cameras[line.Word(0, "a photo")] = line.Word(1, "its camera");
    heading = line.Word(0, "a point") == "-99";
  }
  return cameras;
}

}  // namespace

std::vector<BingoPhoto> ReadBingo(const std::string& path) {
  const std::string file = InFolder(path, "itera.dat");
  std::map<std::string, std::string> cameras = BingoCameras(file);
  std::vector<BingoPhoto> photos;
  for (const TextLine& line : ReadTextLines(file)) {
    if (line.Word(0, "a key") != "ORIA") continue;  // COOR and others are not poses
    BingoPhoto photo;
    photo.number = line.Word(1, "the photo's number");
    photo.camera = cameras[photo.number];
    for (std::size_t j = 0; j < 3; ++j) {
      photo.centre[static_cast<int>(j)] = line.Number(2 + j, "a coordinate");
      photo.opk_gon[static_cast<int>(j)] = line.Number(5 + j, "an angle");
    }
    photos.push_back(photo);
  }
  if (photos.empty()) throw InputError(file + " holds no ORIA line");
  return photos;
}

std::vector<OriPhoto> ReadOri(const std::string& path) {
  const std::string file = InFolder(path, "orientation.ori");
  std::vector<OriPhoto> photos;
  for (const TextLine& line : ReadTextLines(file, "#", ',')) {
    OriPhoto photo;
    photo.name = line.Word(0, "the photo's name");
    if (line.Size() > 7)
      line.Fail("the line has " + std::to_string(line.Size()) +
                " words; a photo's name (in quotes where it has blanks), x, y, z, omega, phi and "
                "kappa are expected");
    for (std::size_t j = 0; j < 3; ++j) {
      photo.centre[static_cast<int>(j)] = line.Number(1 + j, "a coordinate");
      photo.opk_deg[static_cast<int>(j)] = line.Number(4 + j, "an angle");
      if (std::abs(line.Number(4 + j, "an angle")) > 360)
        line.Fail("an angle is " + line.Word(4 + j, "an angle") + "; angles are in degrees");
    }
    photos.push_back(photo);
  }
  if (photos.empty()) throw InputError(file + " holds no photo");
  return photos;
}

std::map<std::string, std::string> ReadPhotoNumbers(const std::string& path) {
  const fs::path folder = fs::is_directory(path) ? fs::path(path) : fs::path(path).parent_path();
  const fs::path file = folder / "photo_numbers.txt";
  std::map<std::string, std::string> names;
  if (!fs::exists(file)) return names;
  for (const TextLine& line : ReadTextLines(file.string()))
    names[line.Word(0, "a number")] = line.Rest(1, "a photo");
  return names;
}

namespace {

// A camera of which only the principal distance is known, not the pixels.
ExchangeCamera CameraOfDistance(double c_mm) {
  ExchangeCamera camera;
  camera.pixel_mm = 1;
  camera.focal_px.setConstant(c_mm);
  if (c_mm > 0) camera.name = fmt::format("c = {:g} mm", c_mm);
  return camera;
}

}  // namespace

ExchangeBlock ExchangeFromPatb(const std::vector<PatbPhoto>& photos,
                               const std::map<std::string, std::string>& names) {
  ExchangeBlock block;
  std::map<double, std::size_t> camera_of;
  for (const PatbPhoto& p : photos) {
    ExchangePhoto photo;
    const auto [camera, is_new] = camera_of.emplace(p.principal_distance_mm, block.cameras.size());
    photo.camera = camera->second;
    if (is_new) block.cameras.push_back(CameraOfDistance(camera->first));
    photo.image = NamedBack(p.number, names);
    photo.centre = p.centre;
    // The nearest rotation, as the file's values are rounded.
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(p.matrix,
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    photo.ground_from_photo = svd.matrixU() * svd.matrixV().transpose();
    block.photos.push_back(photo);
  }
  return block;
}

ExchangeBlock ExchangeFromBingo(const std::vector<BingoPhoto>& photos,
                                const std::map<std::string, std::string>& names) {
  ExchangeBlock block;
  std::map<std::string, std::size_t> camera_of;
  for (const BingoPhoto& p : photos) {
    ExchangePhoto photo;
    // A photo without a camera name belongs to the first camera.
    if (!p.camera.empty()) {
      const auto [camera, is_new] = camera_of.emplace(p.camera, block.cameras.size());
      photo.camera = camera->second;
      if (is_new) block.cameras.emplace_back().name = p.camera;
    }
    photo.image = NamedBack(p.number, names);
    SetPose({p.centre, p.opk_gon / kGonPerRadian}, &photo);
    block.photos.push_back(photo);
  }
  if (block.cameras.empty()) block.cameras.emplace_back();
  return block;
}

ExchangeBlock ExchangeFromOri(const std::vector<OriPhoto>& photos) {
  ExchangeBlock block;
  block.cameras.emplace_back();
  for (const OriPhoto& p : photos) {
    ExchangePhoto photo;
    photo.image = p.name;
    SetPose({p.centre, p.opk_deg * RadFromDeg(1)}, &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
