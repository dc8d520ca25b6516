// Ground points that a person measured in a photo, and the pose that they give it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "exterior/steps/photo_to_orient.h"

namespace orient::exterior {

struct MeasuredPoint {
  std::string name;
  Eigen::Vector3d ground_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  double sigma_px = 1;           // of each coordinate
  bool control = true;           // false: compared with the pose, and no part of it
  bool in_photo_system = false;  // measured there: its pixel follows from the film's position
};

struct PointPose {
  FilmPosition position;  // the one of the photo's that explains the points best
  Pose pose;
  Matrix6d covariance = Matrix6d::Zero();  // of the stated sigmas, larger where residuals are
  std::vector<bool> used = {};             // of every point
  // Measured - computed, of every point; NaN behind the camera.
  std::vector<Eigen::Vector2d> residuals_px = {};
  std::vector<Matrix6d> hidden = {};  // of each used point, PointCheck::hidden
  int Used() const { return static_cast<int>(std::count(used.begin(), used.end(), true)); }
};

}  // namespace orient::exterior
