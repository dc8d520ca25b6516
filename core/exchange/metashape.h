// Agisoft Metashape's (PhotoScan's) cameras XML and its reference table.
//
// A camera's <transform> takes its system (x right, y down, z forward) to the chunk's, the chunk's
// <transform> that one to the world: world = scale * rotation * local + translation. Calibration
// ("frame"), with x = X/Z, y = Y/Z and r2 = x^2 + y^2:
//   x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 x^2) + 2 p2 x y,
//   y' = y (1 + ...)                       + p2 (r2 + 2 y^2) + 2 p1 x y,
//   u = width / 2 + cx + x' f + x' b1 + y' b2,  v = height / 2 + cy + y' f
// in pixels whose upper-left centre is (0.5, 0.5) (Metashape Professional manual, camera models).
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct MetashapeSensor {
  int id = 0;
  std::string label;
  int width = 0, height = 0;
  double pixel_mm = 0.001;
  double f = 0, cx = 0, cy = 0, k1 = 0, k2 = 0, k3 = 0, p1 = 0, p2 = 0, b1 = 0, b2 = 0;
};
struct MetashapeCamera {
  std::string label;
  int sensor = 0;
  Eigen::Matrix4d transform = Eigen::Matrix4d::Identity();
};
struct MetashapeChunk {
  std::vector<MetashapeSensor> sensors;
  std::vector<MetashapeCamera> cameras;  // the aligned ones
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;
  std::string reference;  // WKT of the chunk's coordinate system
};

// Writes cameras.xml in a local coordinate system (metres: the numbers of the block's CRS) and
// reference.txt with label, X, Y, Z, omega, phi, kappa (degrees).
void WriteMetashape(const std::string& directory, const ExchangeBlock& block);

// `path`: the XML file, or the folder with cameras.xml. Throws InputError: a camera that is no
// frame camera, a chunk without cameras.
MetashapeChunk ReadMetashape(const std::string& path);
// In the chunk's world. b1 is held as another focal length in x; throws InputError for a b2 (skew)
// other than 0.
ExchangeBlock ExchangeFromMetashape(const MetashapeChunk& chunk);
// True where the chunk's world is geocentric: its <reference> is no local system.
bool IsGeocentric(const MetashapeChunk& chunk);

}  // namespace orient
