// What COLMAP's files hold, whether text or binary.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

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
// A point of the model in an image.
struct ColmapObservation {
  std::string image;
  Eigen::Vector3d ground = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};
struct ColmapModel {
  std::map<int, ColmapCamera> cameras;
  std::vector<ColmapImage> images;
};

// How many parameters each camera model has that we know.
inline const std::map<std::string, std::size_t> kColmapModels = {
    {"SIMPLE_PINHOLE", 3}, {"PINHOLE", 4}, {"SIMPLE_RADIAL", 4},
    {"RADIAL", 5},         {"OPENCV", 8},  {"FULL_OPENCV", 12}};

}  // namespace orient
