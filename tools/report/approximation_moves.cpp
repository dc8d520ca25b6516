#include "tools/report/approximation_moves.h"

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
    const ApproximationMove move{exterior->approximation->pose.position_m, photo.pose->position_m};
    if ((move.to_m - move.from_m).norm() < kLargest_m) moves.push_back(move);
  }
  return moves;
}

CommonMove CommonMoveOf(const std::vector<ApproximationMove>& moves) {
  CommonMove common;
  if (moves.empty()) return common;
  const auto count = static_cast<double>(moves.size());
  for (const ApproximationMove& move : moves) common.mean_m += (move.to_m - move.from_m) / count;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  for (const ApproximationMove& move : moves)
    squares += (move.to_m - move.from_m - common.mean_m).cwiseAbs2() / count;
  common.rms_about_mean_m = squares.cwiseSqrt();
  return common;
}

}  // namespace orient
