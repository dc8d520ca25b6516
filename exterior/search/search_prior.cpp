#include "exterior/search/search_prior.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "exterior/search/whole_photo_search.h"

namespace orient::exterior {

bool IsVague(const Camera& camera, const PosePrior& prior, double ground_height_m) {
  constexpr double kVagueKappa_rad = 12 * std::numbers::pi / 180;
  constexpr double kShareOfFrame = 0.1;
  const double height = prior.pose.position_m.z() - ground_height_m;
  if (height <= 0) return false;  // wrong, not vague
  const Vector6d sigma = prior.covariance.diagonal().cwiseSqrt();
  if (sigma[5] > kVagueKappa_rad) return true;
  const double moved_mm =
      camera.principal_distance_mm *
      std::hypot(sigma.head<2>().maxCoeff() / height, sigma.segment<2>(3).maxCoeff());
  return moved_mm > kShareOfFrame * camera.frame_mm.minCoeff();
}

bool IsPositionKnown(const PosePrior& prior, double ground_height_m) {
  constexpr double kKnownPerHeight = 0.08;  // largest sigma, as a share of the flying height
  const double height = prior.pose.position_m.z() - ground_height_m;
  return height > 0 &&
         std::sqrt(prior.covariance.diagonal().head<3>().maxCoeff()) <= kKnownPerHeight * height;
}

PosePrior Doubtful(const PosePrior& prior, double ground_height_m) {
  constexpr double kShareOfHeight = 0.03;
  const double height = std::abs(prior.pose.position_m.z() - ground_height_m);
  PosePrior wide = prior;
  wide.covariance *= 4;
  wide.covariance.topLeftCorner<3, 3>() +=
      std::pow(kShareOfHeight * height, 2) * Eigen::Matrix3d::Identity();
  return wide;
}

PosePrior Widened(const PosePrior& prior, double ground_height_m) {
  constexpr double kShareOfHeight = 0.3, kScale = 0.1;
  constexpr double kLeastTilt_rad = 5 * std::numbers::pi / 180;
  constexpr double kMostTilt_rad = 12 * std::numbers::pi / 180;
  const double height = std::max(1.0, prior.pose.position_m.z() - ground_height_m);
  PosePrior wide{prior.pose, Matrix6d(prior.covariance.diagonal().asDiagonal())};
  for (int i = 0; i < 3; ++i)
    wide.covariance(i, i) += std::pow((i < 2 ? kShareOfHeight : kScale) * height, 2);
  for (int i = 3; i < 5; ++i)
    wide.covariance(i, i) =
        std::pow(std::clamp(std::sqrt(wide.covariance(i, i)), kLeastTilt_rad, kMostTilt_rad), 2);
  wide.covariance(5, 5) = std::numbers::pi * std::numbers::pi;
  return wide;
}

std::vector<double> HeightFactors(const PosePrior& prior, double ground_height_m) {
  const double height = prior.pose.position_m.z() - ground_height_m;
  const double sigma = std::sqrt(prior.covariance(2, 2)) / height;
  const double reach = std::log1p(2 * std::min(sigma, 0.5));
  const int steps = std::max(1, static_cast<int>(std::lround(reach / std::log(kHeightStep))));
  std::vector<double> factors = {1};
  for (int i = 1; i <= steps; ++i) {
    factors.push_back(std::pow(kHeightStep, i));
    factors.push_back(std::pow(kHeightStep, -i));
  }
  return factors;
}

std::vector<PosePrior> KappaSectors(const PosePrior& prior, bool all) {
  constexpr double kSector_rad = 2 * std::numbers::pi / kKappaSectors;
  const double variance = prior.covariance(5, 5);
  const double allowed_rad = all ? std::numbers::pi : 3 * std::sqrt(variance) + kSector_rad / 2;
  std::vector<int> order;  // in steps from the prior's own
  for (int k = 0; k < kKappaSectors; ++k)
    if (std::abs(Outwards(k)) * kSector_rad <= allowed_rad) order.push_back(Outwards(k));
  const auto rank = [](int steps) {
    if (steps == 0) return 0;
    return 2 * std::abs(steps) == kKappaSectors ? 1 : 4 * std::abs(steps) == kKappaSectors ? 2 : 3;
  };
  if (std::ssize(order) == kKappaSectors)
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return rank(a) < rank(b); });
  std::vector<PosePrior> sectors;
  for (const int steps : order) {
    PosePrior sector = prior;
    sector.pose.opk_rad.z() += steps * kSector_rad;
    sector.covariance.row(5).setZero();
    sector.covariance.col(5).setZero();
    const double anywhere = kSector_rad * kSector_rad / 12;
    sector.covariance(5, 5) = all ? anywhere : std::min(variance, anywhere);
    sectors.push_back(sector);
  }
  return sectors;
}

}  // namespace orient::exterior
