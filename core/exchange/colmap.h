// COLMAP's text model: cameras.txt, images.txt, points3D.txt
// (https://colmap.github.io/format.html).
//
// Per image a unit quaternion QW QX QY QZ (Hamilton) and a translation T that take world points to
// the camera system: x right, y down, z forward; the centre is -R^T T. Pixels count from the outer
// corner of the upper-left pixel, its centre is (0.5, 0.5), as ours do.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct ColmapCamera {
  std::string model;  // as in the file: "OPENCV"
  int width = 0, height = 0;
  std::vector<double> params;
};
struct ColmapImage {
  std::string name;
  int camera = 0;
  Eigen::Vector4d qvec = Eigen::Vector4d(1, 0, 0, 0);  // w x y z, world to camera
  Eigen::Vector3d tvec = Eigen::Vector3d::Zero();
};
struct ColmapModel {
  std::map<int, ColmapCamera> cameras;
  std::vector<ColmapImage> images;
};

// Writes the three files below `directory`: camera models PINHOLE, OPENCV or FULL_OPENCV, whichever
// holds the distortion. Control points and ties become points3D.
void WriteColmap(const std::string& directory, const ExchangeBlock& block);

// Throws InputError naming file, line and value. Models: SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL,
// RADIAL, OPENCV, FULL_OPENCV (with k4 k5 k6 = 0).
ColmapModel ReadColmap(const std::string& directory);
ExchangeBlock ExchangeFromColmap(const ColmapModel& model);

}  // namespace orient
