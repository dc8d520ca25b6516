#include "exterior/contradicted_sources.h"

#include <algorithm>
#include <map>
#include <set>

#include "core/base/median.h"

namespace orient::exterior {
namespace {

constexpr int kFewestFound = 12;
// Shares of the number of patches used. In correct poses of real and simulated photos, the patches
// that agree elsewhere amount to up to 7 % of it.
constexpr double kShareOfRival = 0.2, kShareElsewhere = 0.1, kShareWorthAWord = 0.05;

struct OfSource {
  int used = 0;
  std::vector<Eigen::Vector2d> rejected_px;

  int Found() const { return used + static_cast<int>(rejected_px.size()); }
};

Eigen::Vector2d MedianOf(const std::vector<Eigen::Vector2d>& residuals_px) {
  std::vector<double> cols, rows;
  for (const Eigen::Vector2d& residual : residuals_px) {
    cols.push_back(residual.x());
    rows.push_back(residual.y());
  }
  return {UpperMedian(std::move(cols)), UpperMedian(std::move(rows))};
}

bool Agree(const std::vector<Eigen::Vector2d>& residuals_px, const Eigen::Vector2d& median_px) {
  const auto close = std::count_if(
      residuals_px.begin(), residuals_px.end(),
      [&](const Eigen::Vector2d& r) { return (r - median_px).norm() < 0.5 * median_px.norm(); });
  return 2 * close > std::ssize(residuals_px);
}

// A patch that was found: used in the pose, or rejected. Residuals of such patches, and shifts, are
// in pixels of the reduction at which they were matched.
struct FoundPatch {
  Eigen::Vector2d pixel, residual_px;
  bool used = false;
};

// Tolerance: matches scatter by some tenths of a pixel, and displaced parts are also deformed.
bool IsAround(const FoundPatch& patch, const Eigen::Vector2d& shift_px) {
  return !patch.used && (patch.residual_px - shift_px).norm() < 0.3 + 0.2 * shift_px.norm();
}

PatchesElsewhere Around(const std::vector<FoundPatch>& found, const Eigen::Vector2d& shift_px) {
  PatchesElsewhere around;
  for (const FoundPatch& patch : found) {
    if (!IsAround(patch, shift_px)) continue;
    around.shift_px += patch.residual_px;
    ++around.patches;
  }
  around.shift_px /= around.patches;
  return around;
}

// Whether most neighbours of patches displaced by about the shift are so displaced, too: 78 to 93 %
// in a displaced part; 8 to 38 % for objects that stand on the ground and for wrong matches, among
// patches that are used.
bool LieTogether(const std::vector<FoundPatch>& found, const Eigen::Vector2d& shift_px) {
  constexpr std::size_t kNeighbours = 4;
  std::vector<FoundPatch> both;  // used, or displaced by about the shift
  for (const FoundPatch& patch : found)
    if (patch.used || IsAround(patch, shift_px)) both.push_back(patch);
  if (both.size() <= kNeighbours) return false;
  std::ptrdiff_t alike = 0, neighbours = 0;
  for (const FoundPatch& patch : found) {
    if (!IsAround(patch, shift_px)) continue;
    const auto distance = [&](const FoundPatch& other) {
      return (other.pixel - patch.pixel).squaredNorm();
    };
    // The first is the patch itself.
    const auto last = both.begin() + kNeighbours + 1;
    std::partial_sort(both.begin(), last, both.end(),
                      [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    alike += std::count_if(both.begin() + 1, last, [](const auto& other) { return !other.used; });
    neighbours += kNeighbours;
  }
  return 2 * alike > neighbours;
}

// The shift on which most patches agree, if it is too large to be a trend of residuals at the pose.
PatchesElsewhere FindElsewhere(const std::vector<FoundPatch>& found, int used) {
  constexpr double kLeastShift_px = 1.5;
  PatchesElsewhere most;
  Eigen::Vector2d densest_px = Eigen::Vector2d::Zero();
  for (const FoundPatch& patch : found) {
    if (patch.used) continue;
    const PatchesElsewhere around = Around(found, patch.residual_px);
    if (around.patches <= most.patches || around.shift_px.norm() < kLeastShift_px) continue;
    most = around;
    densest_px = patch.residual_px;
  }
  if (most.patches < std::max<double>(kFewestFound, kShareWorthAWord * used)) return {};
  return LieTogether(found, densest_px) ? most : PatchesElsewhere();
}

}  // namespace

SourceVotes VotesOf(const std::vector<PatchResult>& results, int reduction) {
  std::map<std::int64_t, OfSource> sources;
  SourceVotes votes;
  for (const PatchResult& result : results) {
    if (!result.source) continue;
    if (result.state == PatchState::kMatched) {
      ++sources[*result.source].used;
      ++votes.used;
    } else if (result.state == PatchState::kRejected && result.residual_px) {
      sources[*result.source].rejected_px.push_back(*result.residual_px);
    }
  }
  std::set<std::int64_t> as_a_whole;  // sources that are contradicted
  for (const auto& [id, of] : sources) {
    const bool has_say = of.Found() >= kFewestFound;
    const bool agrees = 2 * of.used > of.Found();
    if (has_say && agrees) ++votes.agreeing_sources;
    if (has_say && !agrees) {
      const Eigen::Vector2d shift_px = MedianOf(of.rejected_px);
      if (Agree(of.rejected_px, shift_px)) {
        votes.contradicted.push_back({id, of.Found(), of.used, shift_px});
        as_a_whole.insert(id);
      }
    }
  }
  std::vector<FoundPatch> found;
  for (const PatchResult& result : results) {
    const bool used = result.state == PatchState::kMatched;
    if (!result.source || as_a_whole.contains(*result.source) || !result.pixel ||
        !result.residual_px || (!used && result.state != PatchState::kRejected))
      continue;
    found.push_back({*result.pixel, *result.residual_px / reduction, used});
  }
  votes.elsewhere = FindElsewhere(found, votes.used);
  votes.elsewhere.shift_px *= reduction;
  return votes;
}

bool IsUndecided(const SourceVotes& votes) {
  double contradicting = 0;
  for (const ContradictedSource& source : votes.contradicted)
    contradicting += source.found - source.used;
  return std::ssize(votes.contradicted) >= votes.agreeing_sources &&
         contradicting >= kShareOfRival * votes.used && !votes.contradicted.empty();
}

bool IsUndecided(const PatchesElsewhere& elsewhere, int used) {
  return elsewhere.patches > 0 && elsewhere.patches >= kShareElsewhere * used;
}

}  // namespace orient::exterior
