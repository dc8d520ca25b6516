#include "core/exchange/colmap.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <set>
#include <sstream>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/colmap_binary.h"
#include "core/exchange/text_lines.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

std::string Joined(const std::vector<double>& numbers) {
  std::string text;
  for (const double number : numbers) {
    text += ' ';
    text += ExactNumber(number);
  }
  return text;
}

std::string CameraText(const ExchangeCamera& camera) {
  const auto& k = camera.k;
  const auto& p = camera.p;
  std::vector<double> params = {camera.focal_px.x(), camera.focal_px.y(), camera.principal_px.x(),
                                camera.principal_px.y()};
  std::string model = "PINHOLE";
  if (camera.HasDistortion()) {
    model = k[2] == 0 ? "OPENCV" : "FULL_OPENCV";
    params.insert(params.end(), {k[0], k[1], p[1], p[0]});  // OpenCV's p1 is our p2
    if (k[2] != 0) params.insert(params.end(), {k[2], 0, 0, 0});
  }
  return fmt::format("{} {} {}{}\n", model, camera.width, camera.height, Joined(params));
}

constexpr const char* kOriginComment = "# origin, subtracted from ground coordinates:";

// The origin subtracted from ground coordinates, as a comment, so that it can be restored.
std::string OriginComment(const ExchangeBlock& block) {
  std::string text = kOriginComment;
  for (const double value : block.origin) text += " " + ExactNumber(value);
  return text + "\n";
}

std::string ImageText(const ExchangeBlock& block, std::size_t i) {
  const ExchangePhoto& photo = block.photos[i];
  const CameraFromGround camera = CameraFromGroundOf(photo);
  const Eigen::Quaterniond q(camera.rotation);
  const Eigen::Vector3d& t = camera.translation;
  std::string text = std::to_string(i + 1);
  text += Joined({q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()});
  text += fmt::format(" {} {}\n", photo.camera + 1, photo.image);
  return text;
}

std::size_t PhotosOf(const ExchangePoint& point) {
  std::set<std::size_t> photos;
  for (const ExchangeObservation& seen : point.observations) photos.insert(seen.photo);
  return photos.size();
}

// Mean distance between a point's measured and projected pixels; -1, which in COLMAP means unknown,
// if a photo does not show the point.
double ReprojectionError(const ExchangeBlock& block, const ExchangePoint& point) {
  double sum = 0;
  for (const ExchangeObservation& seen : point.observations) {
    const auto pixel = PixelFromGround(block, seen.photo, point.ground);
    if (!pixel) return -1;
    sum += (*pixel - seen.pixel).norm();
  }
  return sum / static_cast<double>(point.observations.size());
}

// The second lines of images.txt and points3D.txt refer to each other by an observation's index.
struct Tracks {
  std::vector<std::string> points2d;  // a photo's line
  std::string points3d;
};

Tracks TracksOf(const ExchangeBlock& block) {
  Tracks tracks;
  tracks.points2d.resize(block.photos.size());
  std::vector<int> count(block.photos.size(), 0);
  for (std::size_t i = 0; i < block.points.size(); ++i) {
    const ExchangePoint& point = block.points[i];
    if (PhotosOf(point) < 2) continue;
    const std::string id = std::to_string(i + 1);
    tracks.points3d += id + Joined({point.ground.x(), point.ground.y(), point.ground.z()});
    tracks.points3d += " 128 128 128" + Joined({ReprojectionError(block, point)});
    for (const ExchangeObservation& seen : point.observations) {
      std::string& line = tracks.points2d[seen.photo];
      if (!line.empty()) line += ' ';
      line += fmt::format("{} {} {}", ExactNumber(seen.pixel.x()), ExactNumber(seen.pixel.y()), id);
      tracks.points3d += fmt::format(" {} {}", seen.photo + 1, count[seen.photo]++);
    }
    tracks.points3d += '\n';
  }
  return tracks;
}

std::string VerificationComments(const ExchangeBlock& block) {
  std::string text;
  for (const VerificationPoint& check : block.verification) {
    text += "# verification: " + block.photos[check.photo].image;
    text += Joined({check.ground.x(), check.ground.y(), check.ground.z()}) + " ->";
    text += Joined({check.pixel.x(), check.pixel.y()}) + "\n";
  }
  return text;
}

ColmapCamera ReadCamera(const TextLine& line) {
  ColmapCamera camera;
  camera.model = line.Word(1, "MODEL");
  camera.width = line.Count(2, "WIDTH");
  camera.height = line.Count(3, "HEIGHT");
  const auto model = kColmapModels.find(camera.model);
  if (model == kColmapModels.end())
    line.Fail("the camera model \"" + camera.model +
              "\" is not supported; undistort the images to PINHOLE or OPENCV first");
  for (std::size_t i = 4; i < line.Size(); ++i) camera.params.push_back(line.Number(i, "PARAMS"));
  if (camera.params.size() != model->second)
    line.Fail(fmt::format("{} has {} parameters, not {}", camera.model, model->second,
                          camera.params.size()));
  return camera;
}

// Requirements of text and binary models alike.
void RequireSupported(const ColmapModel& model, const std::string& directory) {
  for (const auto& [id, camera] : model.cameras)
    if (camera.model == "FULL_OPENCV" &&
        (camera.params[9] != 0 || camera.params[10] != 0 || camera.params[11] != 0))
      throw InputError(
          fmt::format("{}: camera {}: FULL_OPENCV with k4 k5 k6 is not supported: they "
                      "must be 0",
                      directory, id));
  for (const ColmapImage& image : model.images)
    if (!model.cameras.contains(image.camera))
      throw InputError(
          fmt::format("{}: image {}: there is no camera {}", directory, image.name, image.camera));
}

ExchangeCamera ExchangeCameraFrom(int id, const ColmapCamera& colmap) {
  const std::vector<double>& v = colmap.params;
  const bool one_focal = colmap.model.find("PINHOLE") == 7 || colmap.model.ends_with("RADIAL");
  ExchangeCamera camera;
  camera.name = "camera " + std::to_string(id);
  camera.width = colmap.width;
  camera.height = colmap.height;
  const std::size_t c = one_focal ? 1 : 2;  // where cx stands
  camera.focal_px = {v[0], v[c - 1]};
  camera.principal_px = {v[c], v[c + 1]};
  if (colmap.model.ends_with("RADIAL")) camera.k = {v[3], v.size() > 4 ? v[4] : 0, 0};
  if (colmap.model.ends_with("OPENCV")) {
    camera.k = {v[4], v[5], v.size() > 8 ? v[8] : 0};
    camera.p = {v[7], v[6]};
  }
  return camera;
}

// Every image has two lines. The second (its points) may be empty, and missing at the end of the
// file, so that only comments may be skipped.
template <typename Visit>  // void(const TextLine& image, const TextLine* points)
void ForEachImage(const std::string& directory, const Visit& visit) {
  const auto lines = ReadAllTextLines((fs::path(directory) / "images.txt").string(), "#");
  for (std::size_t i = 0; i < lines.size(); i += 2) {
    const bool last = i + 1 == lines.size();
    if (lines[i].Size() == 0) {
      if (last) break;
      lines[i].Fail("an image's line is expected here; each image has two lines");
    }
    visit(lines[i], last ? nullptr : &lines[i + 1]);
  }
}

ColmapModel ReadTextColmap(const std::string& directory) {
  ColmapModel model;
  for (const TextLine& line : ReadTextLines((fs::path(directory) / "cameras.txt").string()))
    model.cameras[line.Count(0, "CAMERA_ID")] = ReadCamera(line);
  ForEachImage(directory, [&](const TextLine& line, const TextLine* /*points*/) {
    ColmapImage image;
    for (std::size_t j = 0; j < 4; ++j) image.qvec[static_cast<int>(j)] = line.Number(1 + j, "Q");
    for (std::size_t j = 0; j < 3; ++j) image.tvec[static_cast<int>(j)] = line.Number(5 + j, "T");
    image.camera = line.Count(8, "CAMERA_ID");
    image.name = line.Rest(9, "NAME");
    if (!(image.qvec.norm() > 0.5)) line.Fail("the quaternion is not of unit length");
    model.images.push_back(image);
  });
  return model;
}

}  // namespace

void WriteColmap(const std::string& directory, const ExchangeBlock& block) {
  std::string cameras = "# CAMERA_ID MODEL WIDTH HEIGHT PARAMS[]\n";
  for (std::size_t i = 0; i < block.cameras.size(); ++i)
    cameras += fmt::format("{} {}", i + 1, CameraText(block.cameras[i]));
  const Tracks tracks = TracksOf(block);
  std::string images = "# IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME\n# X Y POINT3D_ID ...\n" +
                       OriginComment(block) + VerificationComments(block);
  for (std::size_t i = 0; i < block.photos.size(); ++i)
    images += ImageText(block, i) + tracks.points2d[i] + "\n";
  // Binary files that COLMAP made from an earlier export would take precedence over the text.
  for (const char* file : {"cameras.bin", "images.bin", "points3D.bin", "rigs.bin", "frames.bin"})
    fs::remove(fs::path(directory) / file);
  WriteFileAtomically((fs::path(directory) / "cameras.txt").string(), cameras);
  WriteFileAtomically((fs::path(directory) / "images.txt").string(), images);
  WriteFileAtomically((fs::path(directory) / "points3D.txt").string(),
                      "# POINT3D_ID X Y Z R G B ERROR TRACK[] (IMAGE_ID POINT2D_IDX)\n" +
                          OriginComment(block) + tracks.points3d);
}

ColmapModel ReadColmap(const std::string& directory) {
  ColmapModel model =
      HoldsBinaryColmap(directory) ? ReadBinaryColmap(directory) : ReadTextColmap(directory);
  RequireSupported(model, directory);
  return model;
}

std::optional<Eigen::Vector3d> ReadColmapOrigin(const std::string& directory) {
  const std::string path = (fs::path(directory) / "images.txt").string();
  if (!fs::exists(path)) return std::nullopt;
  std::istringstream text(ReadFile(path));
  std::string line;
  while (std::getline(text, line) && line.starts_with('#'))
    if (line.starts_with(kOriginComment)) {
      const std::vector<double> origin =
          ParseNumbers(line.substr(std::string(kOriginComment).size()), path, "the origin");
      if (origin.size() != 3) throw InputError(path + ": the origin must be three numbers");
      return Eigen::Vector3d(origin.data());
    }
  return std::nullopt;
}

std::vector<ColmapObservation> ReadColmapObservations(const std::string& directory) {
  if (HoldsBinaryColmap(directory)) return ReadBinaryColmapObservations(directory);
  const std::string path = (fs::path(directory) / "points3D.txt").string();
  if (!fs::exists(path)) return {};
  std::map<std::string, Eigen::Vector3d> points;
  for (const TextLine& line : ReadTextLines(path))
    points[line.Word(0, "POINT3D_ID")] = {line.Number(1, "X"), line.Number(2, "Y"),
                                          line.Number(3, "Z")};
  std::vector<ColmapObservation> observations;
  ForEachImage(directory, [&](const TextLine& head, const TextLine* seen) {
    for (std::size_t i = 0; seen && i + 2 < seen->Size(); i += 3)
      if (const auto point = points.find(seen->Word(i + 2, "POINT3D_ID")); point != points.end())
        observations.push_back({head.Rest(9, "NAME"),
                                point->second,
                                {seen->Number(i, "X"), seen->Number(i + 1, "Y")}});
  });
  return observations;
}

ExchangeBlock ExchangeFromColmap(const ColmapModel& model) {
  ExchangeBlock block;
  std::map<int, std::size_t> index;
  for (const auto& [id, camera] : model.cameras) {
    index[id] = block.cameras.size();
    block.cameras.push_back(ExchangeCameraFrom(id, camera));
  }
  for (const ColmapImage& image : model.images) {
    const Eigen::Vector4d& q = image.qvec;
    ExchangePhoto photo;
    photo.image = image.name;
    photo.camera = index.at(image.camera);
    SetCameraFromGround(
        {Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(), image.tvec},
        &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
