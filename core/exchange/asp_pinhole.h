// NASA Ames Stereo Pipeline: one pinhole camera <image>.tsai a photo, and ground control as .gcp.
//
// "Frame camera models" of its documentation: P = R Q + C with R camera to world, Q's x right, y
// down, z forward; C and R geocentric (ECEF). Pixel (1/pitch) (fu Q1/Q3 + cu, fv Q2/Q3 + cv), where
// the distortion TSAI is OpenCV's (k1 k2 p1 p2 k3, on Q1/Q3 and Q2/Q3; its k3 needs ASP 3.3 or
// newer). Vision Workbench counts pixels from the centre of the upper-left one: theirs = ours -
// 0.5.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/exchange/exchange_block.h"

namespace orient {

struct AspPinhole {
  std::string image;  // the .tsai file's name without its ending
  double fu = 0, fv = 0, cu = 0, cv = 0, pitch = 1;
  // Where the camera system's axes point; (1 0 0), (0 1 0), (0 0 1) as a rule.
  std::array<Eigen::Vector3d, 3> uvw = {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                        Eigen::Vector3d::UnitZ()};
  Eigen::Vector3d c = Eigen::Vector3d::Zero();
  Eigen::Matrix3d r = Eigen::Matrix3d::Identity();
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
};

// Writes <image without its ending>.tsai for each photo, whose ground system must be geocentric,
// and control.gcp (id lat lon height sigma sigma sigma, then for each image: name col row sigma
// sigma).
void WriteAsp(const std::string& directory, const ExchangeBlock& block);

// All .tsai files of a folder, or one. Throws InputError: other kinds of camera or distortion.
std::vector<AspPinhole> ReadAsp(const std::string& path);
// One camera a photo. Sizes of images are unknown: 0.
ExchangeBlock ExchangeFromAsp(const std::vector<AspPinhole>& photos);

}  // namespace orient
