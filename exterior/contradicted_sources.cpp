#include "exterior/contradicted_sources.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <numbers>

#include "core/base/median.h"

namespace orient::exterior {
namespace {

constexpr int kFewestFound = 12;
// Of the patches used. In right poses of real and simulated photos up to 7 % lie elsewhere
// together.
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

// Matches scatter by some tenths of a pixel, and parts that are displaced are deformed as well.
bool IsAround(const Eigen::Vector2d& residual_px, const Eigen::Vector2d& shift_px) {
  return (residual_px - shift_px).norm() < 0.3 + 0.2 * shift_px.norm();
}

std::ptrdiff_t Around(const std::vector<Eigen::Vector2d>& residuals_px,
                      const Eigen::Vector2d& shift_px) {
  return std::count_if(residuals_px.begin(), residuals_px.end(),
                       [&](const Eigen::Vector2d& r) { return IsAround(r, shift_px); });
}

Eigen::Vector2d MeanAround(const std::vector<Eigen::Vector2d>& residuals_px,
                           const Eigen::Vector2d& shift_px) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const Eigen::Vector2d& residual : residuals_px) {
    if (!IsAround(residual, shift_px)) continue;
    sum += residual;
    ++count;
  }
  return sum / count;
}

// What lies as far off in most other directions: wrong matches, and what stands on the ground.
std::ptrdiff_t InOtherDirections(const std::vector<Eigen::Vector2d>& residuals_px,
                                 const Eigen::Vector2d& shift_px) {
  constexpr int kOthers = 11;
  std::array<std::ptrdiff_t, kOthers> counts = {};
  for (int i = 0; i < kOthers; ++i) {
    const Eigen::Rotation2Dd turn(2 * std::numbers::pi * (i + 1) / (kOthers + 1));
    counts.at(static_cast<std::size_t>(i)) = Around(residuals_px, turn * shift_px);
  }
  // Further displaced parts are the few directions above it.
  const auto upper_quartile = counts.begin() + 3 * kOthers / 4;
  std::nth_element(counts.begin(), upper_quartile, counts.end());
  return *upper_quartile;
}

// The place where most lie, of those that are no trend of the residuals near the pose.
PatchesElsewhere FindElsewhere(const std::vector<Eigen::Vector2d>& residuals_px, int used) {
  constexpr int kTimesOtherDirections = 3;
  constexpr double kLeastShift_px = 1.5;
  PatchesElsewhere found;
  for (const Eigen::Vector2d& residual : residuals_px) {
    const auto around = static_cast<int>(Around(residuals_px, residual));
    if (around <= found.patches) continue;
    const Eigen::Vector2d mean_px = MeanAround(residuals_px, residual);
    if (mean_px.norm() >= kLeastShift_px) found = {around, mean_px};
  }
  if (found.patches < std::max<double>(kFewestFound, kShareWorthAWord * used) ||
      found.patches <= kTimesOtherDirections * InOtherDirections(residuals_px, found.shift_px))
    return {};
  return found;
}

}  // namespace

SourceVotes VotesOf(const std::vector<PatchResult>& results) {
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
  std::vector<Eigen::Vector2d> rejected_px;  // not of sources that are contradicted as a whole
  for (const auto& [id, of] : sources) {
    const bool has_say = of.Found() >= kFewestFound;
    const bool agrees = 2 * of.used > of.Found();
    if (has_say && agrees) ++votes.agreeing_sources;
    if (has_say && !agrees) {
      const Eigen::Vector2d shift_px = MedianOf(of.rejected_px);
      if (Agree(of.rejected_px, shift_px)) {
        votes.contradicted.push_back({id, of.Found(), of.used, shift_px});
        continue;
      }
    }
    rejected_px.insert(rejected_px.end(), of.rejected_px.begin(), of.rejected_px.end());
  }
  votes.elsewhere = FindElsewhere(rejected_px, votes.used);
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
