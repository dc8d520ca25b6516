#include "tools/report/approximation_moves.h"

#include <algorithm>
#include <limits>

namespace orient {
namespace {

constexpr double kLargest_m = 1e7;  // a damaged result must not blow up the map

}  // namespace

std::vector<ApproximationMove> ApproximationMoves(const BlockRecord& block,
                                                  const BlockVerdict& verdict) {
  std::vector<ApproximationMove> moves;
  for (std::size_t i = 0; i < block.photos.size(); ++i) {
    const auto& exterior = block.photos[i].exterior;
    const PhotoVerdict& photo = verdict.photos[i];
    if (!exterior || !exterior->approximation || !photo.pose || photo.status == Status::kFailed)
      continue;
    if (Has(exterior->findings, Reason::kStartedByPoints) ||
        Has(exterior->findings, Reason::kByPointsAlone))
      continue;
    const StartingPose& start = *exterior->approximation;
    const ApproximationMove move{start.pose.position_m, photo.pose->position_m,
                                 start.sigma.head<2>().maxCoeff()};
    if ((move.to_m - move.from_m).norm() < kLargest_m) moves.push_back(move);
  }
  return moves;
}

CommonMove CommonMoveOf(const std::vector<ApproximationMove>& moves) {
  CommonMove common;
  double smallest_m = std::numeric_limits<double>::infinity();
  for (const ApproximationMove& move : moves) smallest_m = std::min(smallest_m, move.sigma_m);
  std::vector<Eigen::Vector3d> shifts;
  for (const ApproximationMove& move : moves)
    if (move.sigma_m <= 2 * smallest_m) shifts.emplace_back(move.to_m - move.from_m);
  common.photos = static_cast<int>(shifts.size());
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& shift : shifts) common.mean_m += shift / common.photos;
  for (const Eigen::Vector3d& shift : shifts)
    squares += (shift - common.mean_m).cwiseAbs2() / common.photos;
  common.rms_about_mean_m = squares.cwiseSqrt();
  return common;
}

}  // namespace orient
