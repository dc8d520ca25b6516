#include "exterior/steps/shared_errors.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "exterior/steps/error_model.h"

namespace orient::exterior {

namespace {

using Cell = std::tuple<std::int64_t, long, long>;  // source, column, row
using Groups = std::map<Cell, std::vector<std::size_t>>;

Groups InCellsOf(double side_m, const std::vector<PatchObservation>& all) {
  Groups groups;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector2d place = (all[i].ground_m.head<2>() / side_m).array().floor();
    groups[{all[i].source, std::lround(place.x()), std::lround(place.y())}].push_back(i);
  }
  return groups;
}

}  // namespace

std::vector<std::vector<std::size_t>> Grouped(const std::vector<PatchObservation>& all) {
  constexpr std::size_t kMost = 250;
  constexpr double kWider = 1.2;
  std::vector<std::vector<std::size_t>> grouped;
  if (all.size() <= kMost) {
    for (std::size_t i = 0; i < all.size(); ++i) grouped.push_back({i});
    return grouped;
  }
  Eigen::AlignedBox2d box;
  for (const PatchObservation& one : all) box.extend(one.ground_m.head<2>());
  double side_m = std::max(box.sizes().maxCoeff(), 1.0) / std::sqrt(static_cast<double>(kMost));
  Groups groups = InCellsOf(side_m, all);
  while (groups.size() > kMost) groups = InCellsOf(side_m *= kWider, all);
  for (auto& [cell, members] : groups) grouped.push_back(std::move(members));
  return grouped;
}

Eigen::MatrixXd HeightCorrelation(const std::vector<PatchObservation>& observations,
                                  HeightFading fading, double length_m) {
  const double short_m = kShortHeightCorrelation * length_m;
  const auto n = std::ssize(observations);
  Eigen::MatrixXd correlation(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double distance = (observations[static_cast<std::size_t>(i)].ground_m -
                               observations[static_cast<std::size_t>(j)].ground_m)
                                  .head<2>()
                                  .norm();
      const double fades = fading == HeightFading::kLong
                               ? std::exp(-distance / length_m)
                               : std::exp(-std::pow(distance / short_m, 2));
      const double value = kCommonHeightShare + (1 - kCommonHeightShare) * fades;
      correlation.block<2, 2>(2 * i, 2 * j).setConstant(value);
      correlation.block<2, 2>(2 * j, 2 * i).setConstant(value);
    }
  return correlation;
}

Eigen::MatrixXd FilmCovariance(const std::vector<PatchObservation>& observations,
                               const CommonErrors& common) {
  const Eigen::Index n = static_cast<Eigen::Index>(observations.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  if (common.film_sigma_px <= 0) return covariance;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double distance = (observations[static_cast<std::size_t>(i)].pixel -
                               observations[static_cast<std::size_t>(j)].pixel)
                                  .norm() /
                              common.film_correlation_px;
      covariance.block<2, 2>(2 * i, 2 * j) = Eigen::Matrix2d::Identity() *
                                             std::pow(common.film_sigma_px, 2) *
                                             std::exp(-distance * distance);
    }
  return covariance;
}

}  // namespace orient::exterior
