#include "block/verdict/approximations_apart.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>

#include "exterior/judge.h"

namespace orient::block {
namespace {

constexpr int kFewest = 3;
constexpr double kClearly = 5;  // standard deviations of the mean
constexpr double kMuch = 1.5;   // standard deviations of one photo's difference

// Sums over the photos with pose and approximation; squares and variances in m^2.
struct Sums {
  int photos = 0;
  Eigen::Array3d off_m = Eigen::Array3d::Zero(), off_m2 = off_m;  // pose minus approximation
  Eigen::Array3d stated_m2 = off_m, of_poses_m2 = off_m;
};

Sums SumsOf(const std::vector<ExteriorResult>& results, const PosePriors& stated) {
  Sums sums;
  for (const ExteriorResult& result : results) {
    const auto prior = stated.find(result.photo);
    if (!result.pose || !result.covariance || prior == stated.end()) continue;
    const Eigen::Array3d off_m = result.pose->position_m - prior->second.pose.position_m;
    ++sums.photos;
    sums.off_m += off_m;
    sums.off_m2 += off_m.square();
    sums.stated_m2 += prior->second.covariance.diagonal().head<3>().array();
    sums.of_poses_m2 += result.covariance->diagonal().head<3>().array();
  }
  return sums;
}

}  // namespace

std::optional<Finding> ApproximationsApart(const std::vector<ExteriorResult>& results,
                                           const PosePriors& stated) {
  const Sums sums = SumsOf(results, stated);
  if (sums.photos < kFewest) return std::nullopt;
  const double photos = sums.photos;
  const Eigen::Array3d mean_m = sums.off_m / photos;
  const Eigen::Array3d stated_m2 = sums.stated_m2 / photos;
  const Eigen::Array3d of_poses_m2 = sums.of_poses_m2 / photos;
  const Eigen::Array3d scatter_m2 = (sums.off_m2 - photos * mean_m.square()) / (photos - 1);
  const Eigen::Array3d of_mean_m = (stated_m2.max(scatter_m2) / photos + of_poses_m2).sqrt();
  const Eigen::Array3d worse = mean_m.abs() / (stated_m2 + of_poses_m2).sqrt();
  const auto apart = (mean_m.abs() > kClearly * of_mean_m && worse > kMuch).eval();
  if (!apart.any()) return std::nullopt;
  return Finding{
      .reason = Reason::kApproximationsWorseThanStated,
      .value = apart.select(worse, 0).maxCoeff(),
      .limit = kMuch,
      .where = fmt::format(
          ": on average the poses of {} photos lie dx {:.1f} dy {:.1f} dz {:.1f} m from them; are "
          "both of one datum and height system, and is the principal distance right?",
          sums.photos, mean_m.x(), mean_m.y(), mean_m.z())};
}

void AddToPhotos(const Finding& apart, const PosePriors& stated,
                 std::vector<ExteriorResult>* results) {
  Finding of_photo = apart;
  of_photo.at_best = Status::kWeak;
  for (ExteriorResult& result : *results)
    if (result.pose && stated.contains(result.photo)) exterior::Add(of_photo, &result);
}

}  // namespace orient::block
