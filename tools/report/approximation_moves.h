// From the photos' approximate positions to their final ones: a shift that all of them have
// in common indicates an error of the approximations' system, not of the photos.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tools/report/block_record.h"
#include "tools/report/verdict.h"

namespace orient {

struct ApproximationMove {
  Eigen::Vector3d from_m, to_m;  // projection centres
  double sigma_m = 0;            // of from_m, the larger one of x and y
};

// Of the photos that have both and did not fail, in the photos' order; without those whose
// orientation started from measured ground points, which are no approximation.
std::vector<ApproximationMove> ApproximationMoves(const BlockRecord& block,
                                                  const BlockVerdict& verdict);

// Common move of the photos with the best approximations (up to twice the smallest sigma:
// not rough ones from a strip or a person), and what remains without it. If there are no moves:
// zeros.
struct CommonMove {
  int photos = 0;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d rms_about_mean_m = Eigen::Vector3d::Zero();  // of each coordinate
};
CommonMove CommonMoveOf(const std::vector<ApproximationMove>& moves);

}  // namespace orient
