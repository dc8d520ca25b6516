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
                                  double length_m) {
  const Eigen::Index n = static_cast<Eigen::Index>(observations.size());
  Eigen::MatrixXd correlation(2 * n, 2 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double distance = (observations[static_cast<std::size_t>(i)].ground_m -
                               observations[static_cast<std::size_t>(j)].ground_m)
                                  .head<2>()
                                  .norm();
      const double value =
          kCommonHeightShare + (1 - kCommonHeightShare) * std::exp(-distance / length_m);
      correlation.block<2, 2>(2 * i, 2 * j).setConstant(value);
      correlation.block<2, 2>(2 * j, 2 * i).setConstant(value);
    }
  return correlation;
}

}  // namespace orient::exterior
