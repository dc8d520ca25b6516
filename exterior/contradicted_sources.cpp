#include "exterior/contradicted_sources.h"

#include <algorithm>
#include <map>

#include "core/base/median.h"

namespace orient::exterior {
namespace {

constexpr int kFewestFound = 12;
constexpr double kShareOfRival = 0.2;  // of the patches used

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

}  // namespace

SourceVotes VotesOf(const std::vector<PatchResult>& results,
                    const std::vector<patchdb::Patch>& patches) {
  std::map<std::int64_t, std::int64_t> source_of;
  for (const patchdb::Patch& patch : patches) source_of[patch.id] = patch.source_id;
  std::map<std::int64_t, OfSource> sources;
  SourceVotes votes;
  for (const PatchResult& result : results) {
    const auto source = source_of.find(result.id);
    if (source == source_of.end()) continue;
    if (result.state == PatchState::kMatched) {
      ++sources[source->second].used;
      ++votes.used;
    } else if (result.state == PatchState::kRejected && result.residual_px) {
      sources[source->second].rejected_px.push_back(*result.residual_px);
    }
  }
  for (const auto& [id, of] : sources) {
    if (of.Found() < kFewestFound) continue;
    if (2 * of.used > of.Found()) {
      ++votes.agreeing_sources;
      continue;
    }
    const Eigen::Vector2d shift_px = MedianOf(of.rejected_px);
    if (Agree(of.rejected_px, shift_px))
      votes.contradicted.push_back({id, of.Found(), of.used, shift_px});
  }
  return votes;
}

bool IsUndecided(const SourceVotes& votes) {
  double contradicting = 0;
  for (const ContradictedSource& source : votes.contradicted)
    contradicting += source.found - source.used;
  return std::ssize(votes.contradicted) >= votes.agreeing_sources &&
         contradicting >= kShareOfRival * votes.used && !votes.contradicted.empty();
}

}  // namespace orient::exterior
