#include "exterior/steps/shared_errors.h"

#include <cmath>

#include "exterior/steps/error_model.h"

namespace orient::exterior {

std::vector<PatchObservation> Thinned(const std::vector<PatchObservation>& all) {
  constexpr std::size_t kMost = 250;
  if (all.size() <= kMost) return all;
  std::vector<PatchObservation> some;
  for (std::size_t i = 0; i < kMost; ++i) some.push_back(all[i * all.size() / kMost]);
  return some;
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
