#include "core/exchange/opensfm.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/base/error.h"
#include "core/exchange/text_lines.h"
#include "core/files/json_fields.h"
#include "core/terrain/geocentric.h"

namespace orient {
namespace {
namespace fs = std::filesystem;

Json Array(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

double LargerSide(int width, int height) { return std::max(width, height); }

Json CameraJson(const ExchangeCamera& camera) {
  const double side = LargerSide(camera.width, camera.height);
  return {{"projection_type", "brown"},
          {"width", camera.width},
          {"height", camera.height},
          {"focal_x", camera.focal_px.x() / side},
          {"focal_y", camera.focal_px.y() / side},
          {"c_x", (camera.principal_px.x() - 0.5 * camera.width) / side},
          {"c_y", (camera.principal_px.y() - 0.5 * camera.height) / side},
          {"k1", camera.k[0]},
          {"k2", camera.k[1]},
          {"p1", camera.p[1]},  // OpenCV's order
          {"p2", camera.p[0]},
          {"k3", camera.k[2]}};
}

Json ShotJson(const ExchangePhoto& photo, const std::string& camera) {
  OpensfmShot shot;
  SetCameraFromGround(CameraFromGroundOf(photo), &shot);
  return {{"rotation", Array(shot.rotation)},
          {"translation", Array(shot.translation)},
          {"camera", camera},
          {"orientation", 1},
          {"capture_time", 0.0},
          {"gps_dop", 1.0},
          {"gps_position", Array(photo.centre)}};
}

// OpenSfM identifies cameras by name: several are numbered, as two may have one name.
std::string CameraName(const ExchangeBlock& block, std::size_t i) {
  return block.cameras[i].name + (block.cameras.size() > 1 ? " #" + std::to_string(i + 1) : "");
}

Json ReconstructionJson(const ExchangeBlock& block) {
  Json cameras = Json::object(), shots = Json::object(), points = Json::object();
  for (std::size_t i = 0; i < block.cameras.size(); ++i)
    cameras[CameraName(block, i)] = CameraJson(block.cameras[i]);
  for (const ExchangePhoto& photo : block.photos)
    shots[photo.image] = ShotJson(photo, CameraName(block, photo.camera));
  for (const ExchangePoint& point : block.points)
    points[point.name] = {{"color", {128.0, 128.0, 128.0}}, {"coordinates", Array(point.ground)}};
  const Eigen::Vector3d& lla = *block.reference_lla;
  return Json::array(
      {{{"cameras", cameras},
        {"shots", shots},
        {"points", points},
        {"reference_lla", {{"latitude", lla[0]}, {"longitude", lla[1]}, {"altitude", lla[2]}}}}});
}

std::string GcpList(const ExchangeBlock& block) {
  const Eigen::Vector3d& lla = *block.reference_lla;
  const Topocentric frame({RadFromDeg(lla[0]), RadFromDeg(lla[1]), lla[2]});
  std::string text = "WGS84\n";
  for (const ExchangePoint& point : block.points) {
    if (!point.control) continue;
    const Geodetic at = GeodeticFromGeocentric(frame.GeocentricFromLocal(point.ground));
    for (const ExchangeObservation& seen : point.observations) {
      for (const double value : {DegFromRad(at.longitude_rad), DegFromRad(at.latitude_rad),
                                 at.height_m, seen.pixel.x() - 0.5, seen.pixel.y() - 0.5}) {
        text += ExactNumber(value);
        text += ' ';
      }
      text += block.photos[seen.photo].image + '\n';
    }
  }
  return text;
}

// OpenSfM's version 2: image, track, feature, x, y, size, colour, and two class labels, which we
// lack. Its bundle adjustment uses the sizes as standard deviations: one pixel each.
std::string TracksText(const ExchangeBlock& block) {
  std::vector<std::string> of_photo(block.photos.size());
  std::vector<int> features(block.photos.size(), 0);
  for (const ExchangePoint& point : block.points)
    for (const ExchangeObservation& seen : point.observations) {
      const ExchangePhoto& photo = block.photos[seen.photo];
      const ExchangeCamera& camera = block.cameras[photo.camera];
      const double side = LargerSide(camera.width, camera.height);
      std::string& text = of_photo[seen.photo];
      text += fmt::format("{}\t{}\t{}", photo.image, point.name, features[seen.photo]++);
      for (const double value : {(seen.pixel.x() - 0.5 * camera.width) / side,
                                 (seen.pixel.y() - 0.5 * camera.height) / side, 1 / side}) {
        text += '\t';
        text += ExactNumber(value);
      }
      text += "\t128\t128\t128\t-1\t-1\n";
    }
  std::string text = "OPENSFM_TRACKS_VERSION_v2\n";
  for (const std::string& lines : of_photo) text += lines;
  return text;
}

double Or0(const std::optional<double>& number) { return number.value_or(0); }

OpensfmCamera ReadCamera(const JsonField& field) {
  OpensfmCamera camera;
  camera.projection_type = field.At("projection_type").AsString();
  camera.width = field.At("width").AsInt();
  camera.height = field.At("height").AsInt();
  const std::vector<std::string> known = {"perspective", "simple_radial", "radial", "brown"};
  if (std::find(known.begin(), known.end(), camera.projection_type) == known.end())
    field.At("projection_type")
        .Fail("\"" + camera.projection_type +
              "\" is not supported; supported are perspective, simple_radial, radial and brown");
  if (const auto focal = field.FindNumber("focal")) {
    camera.focal_x = camera.focal_y = *focal;
  } else {
    camera.focal_x = field.At("focal_x").AsNumber();
    camera.focal_y = field.At("focal_y").AsNumber();
  }
  camera.c_x = Or0(field.FindNumber("c_x"));
  camera.c_y = Or0(field.FindNumber("c_y"));
  camera.k1 = Or0(field.FindNumber("k1"));
  camera.k2 = Or0(field.FindNumber("k2"));
  camera.k3 = Or0(field.FindNumber("k3"));
  camera.p1 = Or0(field.FindNumber("p1"));
  camera.p2 = Or0(field.FindNumber("p2"));
  return camera;
}

// OpenSfM gives a photo without GPS the position 0 0 0 and a gps_dop of 999999; ours is 1.
std::optional<Eigen::Vector3d> GpsOf(const JsonField& shot) {
  constexpr double kNoGps = 1e5;
  if (shot.FindNumber("gps_dop").value_or(0) > kNoGps) return std::nullopt;
  return shot.FindVector3("gps_position");
}

std::string ReconstructionPath(const std::string& directory) {
  return (fs::path(directory) / "reconstruction.json").string();
}

double NumberWithin(const JsonField& field, double most) {
  const double number = field.AsNumber();
  if (!(std::abs(number) <= most))
    field.Fail(fmt::format("is {}; it must lie between {} and {}", number, -most, most));
  return number;
}

OpensfmReconstruction FirstReconstruction(const Json& json, const std::string& directory) {
  const std::string path = ReconstructionPath(directory);
  const auto all = JsonField(json, path).Elements();
  if (all.empty()) throw InputError(path + " holds no reconstruction");
  const JsonField& first = all.front();
  OpensfmReconstruction reconstruction;
  reconstruction.others = all.size() - 1;
  const JsonField cameras = first.At("cameras"), shots = first.At("shots");
  for (const auto& item : json.at(0).at("cameras").items())
    reconstruction.cameras[item.key()] = ReadCamera(cameras.At(item.key()));
  for (const auto& item : json.at(0).at("shots").items()) {
    const JsonField field = shots.At(item.key());
    OpensfmShot shot{item.key(), field.At("camera").AsString(), field.At("rotation").AsVector3(),
                     field.At("translation").AsVector3(), GpsOf(field)};
    if (!reconstruction.cameras.contains(shot.camera))
      field.At("camera").Fail(fmt::format("\"{}\" is not among the cameras", shot.camera));
    reconstruction.shots.push_back(std::move(shot));
  }
  if (const auto lla = first.Find("reference_lla"))
    reconstruction.reference_lla = Eigen::Vector3d(NumberWithin(lla->At("latitude"), 90),
                                                   NumberWithin(lla->At("longitude"), 180),
                                                   NumberWithin(lla->At("altitude"), 1e5));
  return reconstruction;
}

std::map<std::string, Eigen::Vector3d> PointsOf(const Json& json, const std::string& directory) {
  std::map<std::string, Eigen::Vector3d> points;
  const JsonField first = JsonField(json, ReconstructionPath(directory)).Elements().front();
  const auto field = first.Find("points");
  if (!field) return points;
  for (const auto& item : json.at(0).at("points").items())
    points[item.key()] = field->At(item.key()).At("coordinates").AsVector3();
  return points;
}

std::vector<std::string> TabbedCells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream words(line);
  for (std::string cell; std::getline(words, cell, '\t');) cells.push_back(cell);
  return cells;
}

}  // namespace

CameraFromGround CameraFromGroundOf(const OpensfmShot& shot) {
  const double angle = shot.rotation.norm();
  CameraFromGround camera{Eigen::Matrix3d::Identity(), shot.translation};
  if (angle > 0)
    camera.rotation = Eigen::AngleAxisd(angle, shot.rotation / angle).toRotationMatrix();
  return camera;
}

void SetCameraFromGround(const CameraFromGround& camera, OpensfmShot* shot) {
  const Eigen::AngleAxisd turn{Eigen::Quaterniond(camera.rotation)};
  shot->rotation = turn.angle() * turn.axis();
  shot->translation = camera.translation;
}

void WriteOpensfm(const std::string& directory, const ExchangeBlock& block) {
  if (!block.reference_lla)
    throw std::invalid_argument("WriteOpensfm: the block has no topocentric ground system");
  const Eigen::Vector3d& lla = *block.reference_lla;
  const Json reference = {{"latitude", lla[0]}, {"longitude", lla[1]}, {"altitude", lla[2]}};
  WriteFileAtomically(ReconstructionPath(directory), ReconstructionJson(block).dump(2) + "\n");
  WriteFileAtomically((fs::path(directory) / "reference_lla.json").string(),
                      reference.dump(2) + "\n");
  const bool control = std::any_of(block.points.begin(), block.points.end(),
                                   [](const ExchangePoint& point) { return point.control; });
  // Files of an earlier block would be read together with this one.
  for (const char* file : {"gcp_list.txt", "tracks.csv"}) fs::remove(fs::path(directory) / file);
  if (control) WriteFileAtomically((fs::path(directory) / "gcp_list.txt").string(), GcpList(block));
  if (!block.points.empty())
    WriteFileAtomically((fs::path(directory) / "tracks.csv").string(), TracksText(block));
}

OpensfmReconstruction ReadOpensfm(const std::string& directory) {
  return FirstReconstruction(ParseJsonFile(ReconstructionPath(directory)), directory);
}

std::vector<OpensfmObservation> ReadOpensfmObservations(const std::string& directory) {
  const std::string path = (fs::path(directory) / "tracks.csv").string();
  if (!fs::exists(path)) return {};
  const Json json = ParseJsonFile(ReconstructionPath(directory));
  const OpensfmReconstruction reconstruction = FirstReconstruction(json, directory);
  std::map<std::string, const OpensfmCamera*> cameras;
  for (const OpensfmShot& shot : reconstruction.shots)
    cameras[shot.image] = &reconstruction.cameras.at(shot.camera);
  const std::map<std::string, Eigen::Vector3d> points = PointsOf(json, directory);
  std::vector<OpensfmObservation> observations;
  std::istringstream lines(ReadFile(path));
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.empty() || line.starts_with("OPENSFM_TRACKS_VERSION")) continue;
    const std::string where = fmt::format("{}, line {}", path, number);
    const std::vector<std::string> cells = TabbedCells(line);
    if (cells.size() < 5)
      throw InputError(where + ": image, track, feature, x, y are expected, separated by tabs");
    const auto camera = cameras.find(cells[0]);
    const auto point = points.find(cells[1]);
    if (camera == cameras.end() || point == points.end()) continue;
    const Eigen::Vector2d normalised(ParseNumber(cells[3], where, "x"),
                                     ParseNumber(cells[4], where, "y"));
    const OpensfmCamera& c = *camera->second;
    const Eigen::Vector2d middle = 0.5 * Eigen::Vector2d(c.width, c.height);
    observations.push_back(
        {cells[0], point->second, LargerSide(c.width, c.height) * normalised + middle});
  }
  return observations;
}

ExchangeBlock ExchangeFromOpensfm(const OpensfmReconstruction& reconstruction) {
  ExchangeBlock block;
  block.reference_lla = reconstruction.reference_lla;
  std::map<std::string, std::size_t> index;
  for (const auto& [name, c] : reconstruction.cameras) {
    index[name] = block.cameras.size();
    const double side = LargerSide(c.width, c.height);
    ExchangeCamera camera;
    camera.name = name;
    camera.width = c.width;
    camera.height = c.height;
    camera.focal_px = side * Eigen::Vector2d(c.focal_x, c.focal_y);
    camera.principal_px =
        side * Eigen::Vector2d(c.c_x, c.c_y) + 0.5 * Eigen::Vector2d(c.width, c.height);
    camera.k = {c.k1, c.k2, c.k3};
    camera.p = {c.p2, c.p1};
    block.cameras.push_back(camera);
  }
  for (const OpensfmShot& shot : reconstruction.shots) {
    ExchangePhoto photo;
    photo.image = shot.image;
    photo.camera = index.at(shot.camera);
    SetCameraFromGround(CameraFromGroundOf(shot), &photo);
    block.photos.push_back(photo);
  }
  return block;
}

}  // namespace orient
