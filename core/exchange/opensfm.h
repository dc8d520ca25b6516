// OpenSfM's reconstruction.json, tracks.csv and gcp_list.txt
// (https://opensfm.org/docs/geometry.html, gcp.html).
//
// A shot's rotation (angle-axis) and translation take world points to the camera system: x right, y
// down, z forward. Normalised image coordinates have their origin in the image's middle and the
// larger side as unit: x_n = (col - width / 2) / max(width, height) in our pixels (theirs have
// whole numbers at the pixels' centres). World is topocentric: east, north, up at reference_lla
// (WGS 84); OpenDroneMap leaves files of one name whose world is projected.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct OpensfmCamera {
  std::string projection_type;  // perspective, simple_radial, radial or brown
  int width = 0, height = 0;
  double focal_x = 0, focal_y = 0, c_x = 0, c_y = 0;
  double k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0;
};
struct OpensfmShot {
  std::string image, camera;
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero(), translation = Eigen::Vector3d::Zero();
  // What the flight recorded; topocentric whatever the poses are in. Empty where nothing was.
  std::optional<Eigen::Vector3d> gps_position;
};
CameraFromGround CameraFromGroundOf(const OpensfmShot& shot);
void SetCameraFromGround(const CameraFromGround& camera, OpensfmShot* shot);

// A point of the reconstruction in an image.
struct OpensfmObservation {
  std::string image;
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  // ours: the first centre is 0.5
};
struct OpensfmReconstruction {
  std::map<std::string, OpensfmCamera> cameras;
  std::vector<OpensfmShot> shots;
  std::size_t others = 0;  // further reconstructions of the file, each in a system of its own
  std::optional<Eigen::Vector3d> reference_lla;  // latitude, longitude, altitude
};

// Writes reconstruction.json and reference_lla.json; with control points gcp_list.txt, whose first
// line is "WGS84" and whose points are longitude, latitude, height and a pixel with whole numbers
// at the pixels' centres; with points tracks.csv (version 2), whose normalised coordinates are
// those of the file's head. Needs block.reference_lla.
void WriteOpensfm(const std::string& directory, const ExchangeBlock& block);

// Of the first reconstruction. Throws InputError naming file and field.
OpensfmReconstruction ReadOpensfm(const std::string& directory);
// Of tracks.csv beside it (version 1 or 2), for tracks that are points of the first reconstruction;
// empty where there is no such file.
std::vector<OpensfmObservation> ReadOpensfmObservations(const std::string& directory);
ExchangeBlock ExchangeFromOpensfm(const OpensfmReconstruction& reconstruction);

}  // namespace orient
