// A tie point: one place on the ground, measured in two or more photos.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "core/terrain/photo_view.h"
#include "exterior/steps/photo_image.h"

namespace orient::block {

// A photo whose pose is known at least roughly.
struct TiePhoto {
  std::string name;
  PhotoView view;
  Matrix6d pose_covariance = Matrix6d::Zero();  // in the order of Vector6d
  const exterior::PhotoImage* image = nullptr;  // not owned
};

struct TieSighting {
  std::size_t photo = 0;  // index into the photos
  Eigen::Vector2d pixel;  // scan
  Eigen::Matrix2d covariance_px2;
  double ncc = 1;  // with the owner's window
};

struct MeasuredTie {
  Eigen::Vector3d ground_m;       // on the surface under the owner's pose: a first value
  std::vector<TieSighting> seen;  // the owner first; at least two
};

struct TieOptions {
  int cells = 15;           // of a frame, each way
  int window_px = 256;      // side of what is searched for interest points, at most a cell
  int template_px = 35;     // side of a matched window
  double min_score = 0.65;  // NCC
};

}  // namespace orient::block
