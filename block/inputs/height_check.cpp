#include "tools/height_check.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/format_text.h"
#include "core/median.h"

namespace orient {
namespace {

constexpr std::size_t kEnough = 6;
constexpr double kMissing = 0.3;
constexpr double kSigmas = 3;
constexpr double kNormalFromMedian = 1.4826;

struct Differences {
  std::vector<double> above_m;  // DEM - patch
  std::vector<double> sigma_m;  // of the patches' heights
  std::size_t matched = 0;
};

Differences Compare(const GroundSurface& dem, const std::vector<Patch>& patches,
                    const ExteriorResult& result) {
  std::set<std::int64_t> matched;
  for (const PatchResult& patch : result.patches)
    if (patch.state == PatchState::kMatched) matched.insert(patch.id);
  Differences differences;
  differences.matched = matched.size();
  for (const Patch& patch : patches) {
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
  return kNormalFromMedian * UpperMedian(std::move(values));
}

}  // namespace

void CheckHeights(const GroundSurface& dem, const std::vector<Patch>& patches, double tolerance_m,
                  ExteriorResult* result) {
  if (!result->pose) return;
  const Differences found = Compare(dem, patches, *result);
  const auto missing = static_cast<double>(found.matched - found.above_m.size());
  if (missing > kMissing * static_cast<double>(found.matched))
    result->messages.push_back(
        FormatText("the DEM has no height under %.0f of the %zu matched patches: it has a hole "
                   "there, or ends",
                   missing, found.matched));
  if (found.above_m.size() < kEnough) return;
  const double median = UpperMedian(found.above_m);
  const double spread = SpreadAbout(median, found.above_m);
  const double allowed = std::max(kSigmas * UpperMedian(found.sigma_m), tolerance_m);
  if (spread > allowed) {
    result->status = Status::kWeak;
    result->messages.push_back(FormatText(
        "the DEM's heights differ from the matched patches' by %.0f m (one sigma; %.0f m would be "
        "expected at most): the patches' coordinates or the DEM's are those of another place",
        spread, allowed));
  } else if (std::abs(median) > allowed) {
    result->status = Status::kWeak;
    result->messages.push_back(
        FormatText("the DEM lies %.0f m %s the matched patches (spread %.0f m): one of them has "
                   "another height datum; the pose has the patches'",
                   std::abs(median), median > 0 ? "above" : "below", spread));
  }
}

}  // namespace orient
