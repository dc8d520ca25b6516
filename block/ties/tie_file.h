// <photo>.ties.json: the tie points that a photo owns, between two stages of `orient block`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/files/inputs.h"

namespace orient::block {

struct SightingRecord {
  std::string photo;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2;
  double ncc = 0;
};

struct TieRecord {
  Eigen::Vector3d ground_m;  // roughly
  std::vector<SightingRecord> seen;
};

void WriteTieFile(const std::string& path, const std::string& owner, const Inputs& made_from,
                  const std::vector<TieRecord>& ties);
// Throws InputError naming the file.
std::vector<TieRecord> ReadTieFile(const std::string& path);

}  // namespace orient::block
