#include "block/verdict/approximations_apart.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>

#include "exterior/judge.h"

namespace orient::block {
namespace {

constexpr Eigen::Index kFewest = 3;
constexpr double kClearly = 5;  // standard deviations of the mean
constexpr double kMuch = 1.5;   // standard deviations of one photo's difference

// Of each photo with both, a row.
struct Differences {
  Eigen::MatrixX3d pose_minus_approximation_m, variance_m2, variance_of_pose_m2;
};

Differences DifferencesOf(const std::vector<ExteriorResult>& results, const PosePriors& stated) {
  Differences all;
  for (Eigen::MatrixX3d* of :
       {&all.pose_minus_approximation_m, &all.variance_m2, &all.variance_of_pose_m2})
    of->resize(std::ssize(results), 3);
  Eigen::Index count = 0;
  for (const ExteriorResult& result : results) {
    const auto prior = stated.find(result.photo);
    if (!result.pose || !result.covariance || prior == stated.end()) continue;
    all.pose_minus_approximation_m.row(count) =
        result.pose->position_m - prior->second.pose.position_m;
    all.variance_m2.row(count) = prior->second.covariance.diagonal().head<3>();
    all.variance_of_pose_m2.row(count++) = result.covariance->diagonal().head<3>();
  }
  for (Eigen::MatrixX3d* of :
       {&all.pose_minus_approximation_m, &all.variance_m2, &all.variance_of_pose_m2})
    of->conservativeResize(count, 3);
  return all;
}

}  // namespace

std::optional<Finding> ApproximationsApart(const std::vector<ExteriorResult>& results,
                                           const PosePriors& stated) {
  const Differences all = DifferencesOf(results, stated);
  const Eigen::MatrixX3d& off_m = all.pose_minus_approximation_m;
  if (off_m.rows() < kFewest) return std::nullopt;
  const auto photos = static_cast<double>(off_m.rows());
  const Eigen::RowVector3d mean_m = off_m.colwise().mean();
  const Eigen::Array3d stated_m2 = all.variance_m2.colwise().mean();
  const Eigen::Array3d of_poses_m2 = all.variance_of_pose_m2.colwise().mean();
  const Eigen::Array3d scatter_m2 =
      (off_m.rowwise() - mean_m).colwise().squaredNorm() / (photos - 1);
  const Eigen::Array3d of_mean_m = (stated_m2.max(scatter_m2) / photos + of_poses_m2).sqrt();
  const Eigen::Array3d mean_abs_m = mean_m.cwiseAbs();
  const Eigen::Array3d worse = mean_abs_m / (stated_m2 + of_poses_m2).sqrt();
  const auto apart = (mean_abs_m > kClearly * of_mean_m && worse > kMuch).eval();
  if (!apart.any()) return std::nullopt;
  return Finding{
      .reason = Reason::kApproximationsWorseThanStated,
      .value = apart.select(worse, 0).maxCoeff(),
      .limit = kMuch,
      .where = fmt::format(
          ": on average the poses of {} photos lie dx {:.1f} dy {:.1f} dz {:.1f} m from them; are "
          "both of one datum and height system, and is the principal distance right?",
          off_m.rows(), mean_m.x(), mean_m.y(), mean_m.z())};
}

void AddToPhotos(const Finding& apart, const PosePriors& stated,
                 std::vector<ExteriorResult>* results) {
  Finding of_photo = apart;
  of_photo.at_best = Status::kWeak;
  for (ExteriorResult& result : *results)
    if (result.pose && stated.contains(result.photo)) exterior::Add(of_photo, &result);
}

}  // namespace orient::block
