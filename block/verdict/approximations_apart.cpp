#include "block/verdict/approximations_apart.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>

namespace orient::block {
namespace {

constexpr Eigen::Index kFewest = 3;
constexpr double kClearly = 5;  // standard deviations of the mean
constexpr double kMuch = 1.5;   // stated standard deviations of one photo

// Of each photo with both, a row.
struct Differences {
  Eigen::MatrixX3d pose_minus_approximation_m, sigma_m;
};

Differences DifferencesOf(const std::vector<ExteriorResult>& results) {
  Differences differences;
  auto& [difference_m, sigma_m] = differences;
  difference_m.resize(std::ssize(results), 3);
  sigma_m.resize(std::ssize(results), 3);
  Eigen::Index count = 0;
  for (const ExteriorResult& result : results) {
    if (!result.pose || !result.approximation) continue;
    difference_m.row(count) = result.pose->position_m - result.approximation->pose.position_m;
    sigma_m.row(count++) = result.approximation->sigma.head<3>();
  }
  difference_m.conservativeResize(count, 3);
  sigma_m.conservativeResize(count, 3);
  return differences;
}

}  // namespace

std::optional<Finding> ApproximationsApart(const std::vector<ExteriorResult>& results) {
  const auto [difference_m, sigma_m] = DifferencesOf(results);
  const Eigen::Index count = difference_m.rows();
  if (count < kFewest) return std::nullopt;
  const auto photos = static_cast<double>(count);
  const Eigen::Array3d mean_m = difference_m.colwise().mean();
  const Eigen::Array3d stated_m = (sigma_m.colwise().squaredNorm() / photos).cwiseSqrt();
  const Eigen::Array3d scatter_m =
      ((difference_m.rowwise() - mean_m.matrix().transpose()).colwise().squaredNorm() /
       (photos - 1))
          .cwiseSqrt();
  const Eigen::Array3d of_mean_m = stated_m.max(scatter_m) / std::sqrt(photos);
  const Eigen::Array3d worse = mean_m.abs() / stated_m;
  if (!(mean_m.abs() > kClearly * of_mean_m && worse > kMuch).any()) return std::nullopt;
  return Finding{.reason = Reason::kApproximationsWorseThanStated,
                 .value = worse.maxCoeff(),
                 .limit = kMuch,
                 .where = fmt::format(
                     ": on average the poses of {} photos lie dx {:.1f} dy {:.1f} dz {:.1f} m "
                     "from theirs, as if they and the control were of different datums",
                     count, mean_m.x(), mean_m.y(), mean_m.z())};
}

}  // namespace orient::block
