#include "block/ties/tie_points.h"

#include <Eigen/Dense>

#include "block/ties/tie_matching.h"
#include "block/ties/tie_places.h"
#include "core/base/error.h"
#include "core/base/side_by_side.h"
#include "core/matching/least_squares_matching.h"

namespace orient::block {
namespace {

// Each photo takes half of the covariance of a difference of two photos: then the differences of
// any two photos of the tie are equally uncertain.
void ShareCovariance(MeasuredTie* tie) {
  const Eigen::Matrix2d model =
      kMatchModelSigma_px * kMatchModelSigma_px * Eigen::Matrix2d::Identity();
  double owners = 0;
  for (std::size_t i = 1; i < tie->seen.size(); ++i) {
    Eigen::Matrix2d& covariance = tie->seen[i].covariance_px2;
    covariance = covariance / 2 + model;
    owners += covariance.trace() / 2 / static_cast<double>(tie->seen.size() - 1);
  }
  tie->seen.front().covariance_px2 = owners * Eigen::Matrix2d::Identity();
}

std::optional<MeasuredTie> MeasurePlace(const std::vector<TiePhoto>& photos, std::size_t owner,
                                        const TiePlace& place, const GroundSurface& surface,
                                        const TieOptions& options) {
  MeasuredTie tie{place.ground_m, {{owner, place.pixel, Eigen::Matrix2d::Zero(), 1}}};
  for (const std::size_t other : place.further) {
    std::optional<TieSighting> sighting;
    try {
      sighting = MatchPlace(photos[owner], photos[other], place, surface, options);
    } catch (const InputError&) {  // a scan damaged there shows nothing; others may
    }
    if (!sighting) continue;
    sighting->photo = other;
    tie.seen.push_back(*sighting);
  }
  if (tie.seen.size() < 2) return std::nullopt;
  ShareCovariance(&tie);
  return tie;
}

}  // namespace

std::vector<MeasuredTie> FindTies(const std::vector<TiePhoto>& photos, std::size_t owner,
                                  const GroundSurface& surface, const TieOptions& options) {
  const auto cells = FindTiePlaces(photos, owner, surface, options);
  std::vector<std::optional<MeasuredTie>> found(cells.size());
  SideBySide(cells.size(), [&](std::size_t i) {
    for (const TiePlace& place : cells[i]) {
      found[i] = MeasurePlace(photos, owner, place, surface, options);
      if (found[i]) break;
    }
  });
  std::vector<MeasuredTie> ties;
  for (auto& tie : found)
    if (tie) ties.push_back(std::move(*tie));
  return ties;
}

}  // namespace orient::block
