// Agisoft Metashape's (PhotoScan's) cameras XML and its reference table.
//
// A camera's <transform> takes its system (x right, y down, z forward) to the chunk's, the chunk's
// <transform> that one to the world: world = scale * rotation * local + translation (since 1.5 the
// transform of each of the chunk's components, of which the active one is read). Calibration
// ("frame"), with x = X/Z, y = Y/Z and r2 = x^2 + y^2:
//   x' = x (1 + k1 r2 + k2 r2^2 + k3 r2^3) + p1 (r2 + 2 x^2) + 2 p2 x y,
//   y' = y (1 + ...)                       + p2 (r2 + 2 y^2) + 2 p1 x y,
//   u = width / 2 + cx + x' f + x' b1 + y' b2,  v = height / 2 + cy + y' f
// in pixels whose upper-left centre is (0.5, 0.5) (Metashape Professional manual, camera models).
// PhotoScan wrote fx = f + b1, fy = f, skew = b2, and cx and cy as a pixel of the image.
#pragma once

#include <Eigen/Core>
#include <optional>
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
  // Its measured position in the chunk's coordinate system, where that is enabled.
  std::optional<Eigen::Vector3d> reference;
};
struct MetashapeChunk {
  std::vector<MetashapeSensor> sensors;
  std::vector<MetashapeCamera> cameras;  // the enabled and aligned ones of the active component
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  double scale = 1;
  bool placed = false;    // whether there is a <transform>; else the chunk's system is its own
  std::string reference;  // WKT of the chunk's coordinate system
  double accuracy_m = 0;  // of the cameras' references; 0 where not stated
  // What was not read.
  std::size_t other_chunks = 0, disabled = 0, not_aligned = 0, of_other_components = 0;
};

// Writes cameras.xml in a local coordinate system (metres: the numbers of the block's CRS) and
// reference.txt with label, X, Y, Z, omega, phi, kappa (degrees).
void WriteMetashape(const std::string& directory, const ExchangeBlock& block);

// `path`: the XML file, or the folder with cameras.xml. Throws InputError: a camera that is no
// frame camera, a chunk without cameras that are enabled and aligned.
MetashapeChunk ReadMetashape(const std::string& path);
// In the chunk's world. b1 is held as another focal length in x; throws InputError for a b2 (skew)
// other than 0.
ExchangeBlock ExchangeFromMetashape(const MetashapeChunk& chunk);
// True where the chunk's world is geocentric: its <reference> is no local system.
bool IsGeocentric(const MetashapeChunk& chunk);

}  // namespace orient
