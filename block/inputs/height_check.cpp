#include "block/inputs/height_check.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/median.h"
#include "exterior/judge.h"

namespace orient::block {
namespace {

constexpr std::size_t kEnough = 6;
constexpr double kMissing = 0.3;
constexpr double kSigmas = 3;

struct Differences {
  std::vector<double> above_m;  // DEM - patch
  std::vector<double> sigma_m;  // of the patches' heights
  std::size_t matched = 0;
};

Differences Compare(const GroundSurface& dem, const std::vector<patchdb::Patch>& patches,
                    const ExteriorResult& result) {
  std::set<std::int64_t> matched;
  for (const PatchResult& patch : result.patches)
    if (patch.state == PatchState::kMatched) matched.insert(patch.id);
  Differences differences;
  differences.matched = matched.size();
  for (const patchdb::Patch& patch : patches) {
    if (matched.count(patch.id) == 0) continue;
    const auto height = dem.HeightAt(patch.ground_m.x(), patch.ground_m.y());
    if (!height) continue;
    differences.above_m.push_back(*height - patch.ground_m.z());
    differences.sigma_m.push_back(
        patch.height_sigma_m.value_or(std::sqrt(std::max(0.0, patch.covariance_m2(2, 2)))));
  }
  return differences;
}

double SpreadAbout(double middle, std::vector<double> values) {
  for (double& value : values) value = std::abs(value - middle);
  return kSigmaOfMedianDeviation * UpperMedian(std::move(values));
}

}  // namespace

void CheckHeights(const GroundSurface& dem, const std::vector<patchdb::Patch>& patches,
                  double tolerance_m, ExteriorResult* result) {
  if (!result->pose) return;
  const auto add = [&](const Finding& finding) { exterior::Add(finding, result); };
  const Differences found = Compare(dem, patches, *result);
  const auto missing = static_cast<double>(found.matched - found.above_m.size());
  if (missing > kMissing * static_cast<double>(found.matched))
    add({Reason::kDemHasHoles, Status::kOk, missing, static_cast<double>(found.matched)});
  if (found.above_m.size() < kEnough) return;
  const double median = UpperMedian(found.above_m);
  const double spread = SpreadAbout(median, found.above_m);
  const double allowed = std::max(kSigmas * UpperMedian(found.sigma_m), tolerance_m);
  if (spread > allowed)
    add({Reason::kDemUnlikePatches, Status::kWeak, spread, allowed});
  else if (std::abs(median) > allowed)
    add({Reason::kDemDatum, Status::kWeak, std::abs(median), spread,
         median > 0 ? "above" : "below"});
}

}  // namespace orient::block
