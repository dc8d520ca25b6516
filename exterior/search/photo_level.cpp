#include "exterior/search/photo_level.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/side_by_side.h"
#include "core/matching/correlation.h"

namespace orient::exterior {
namespace {

constexpr int kTile_px = 288;          // pixels of the level; its spectrum is fast to compute
constexpr double kPeakDistance = 2.5;  // pixels of the level

}  // namespace

int FinestReduction(const PhotoImage& photo, double most_pixels) {
  int reduction = 1;
  const double pixels = static_cast<double>(photo.Width()) * photo.Height();
  while (pixels > most_pixels * reduction * reduction) ++reduction;
  return reduction;
}

PhotoLevel::PhotoLevel(const PhotoImage& photo, int reduction, int side)
    : reduction_(reduction), side_(side) {
  // Each template position lies in one tile only: neighbours overlap by a template less one pixel.
  // The last tiles reach beyond the photo, so that all are of one size.
  const int step = kTile_px - (side - 1);
  std::vector<Eigen::Vector2d> corners;
  for (int row = 0; (row + side) * reduction <= photo.Height(); row += step)
    for (int col = 0; (col + side) * reduction <= photo.Width(); col += step)
      corners.emplace_back(col, row);
  const Eigen::Vector2d middle = Eigen::Vector2d::Constant(side / 2.0);
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(kTile_px / 2.0);
  std::vector<std::optional<Tile>> tiles(corners.size());
  SideBySide(tiles.size(), [&](std::size_t i) {
    ImageWindow window = photo.Around(reduction * (corners[i] + half), reduction * half, reduction);
    ChannelCorrelator search(window.image, side);
    window.image = {};  // the correlator has what it needs
    tiles[i].emplace(Tile{reduction * (corners[i] + middle),
                          reduction * (corners[i] + middle + Eigen::Vector2d::Constant(step)),
                          std::move(window), std::move(search)});
  });
  for (std::optional<Tile>& tile : tiles) tiles_.push_back(std::move(*tile));
}

PhotoLevel::Places PhotoLevel::Find(const Image& image, const Eigen::Vector2d& around_px,
                                    double radius_px, int at_most, double min_score) const {
  const Eigen::Vector2d middle = Eigen::Vector2d::Constant(side_ / 2.0);
  const auto templ = tiles_.front().search.Prepare(image);
  Places places;
  for (const Tile& tile : tiles_) {
    const Eigen::Vector2d nearest = around_px.cwiseMax(tile.first_px).cwiseMin(tile.last_px);
    if ((nearest - around_px).norm() > radius_px) continue;
    const Image scores = tile.search.Scores(templ);
    // Positions beyond the photo and those without texture do not count.
    const auto searched = std::count_if(scores.values.begin(), scores.values.end(),
                                        [](float score) { return !std::isnan(score); });
    places.area_px2 += static_cast<double>(searched) * reduction_ * reduction_;
    for (const Peak& peak : FindPeaks(scores, at_most, kPeakDistance, min_score))
      places.best.push_back({tile.window.RasterFromImage(peak.position + middle), peak.score});
  }
  std::stable_sort(places.best.begin(), places.best.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
  // A peak at a seam has a shoulder in the next tile.
  std::vector<Candidate> apart;
  for (const Candidate& place : places.best) {
    if (std::ssize(apart) >= at_most) break;
    const bool shoulder = std::any_of(apart.begin(), apart.end(), [&](const Candidate& better) {
      return (better.pixel - place.pixel).norm() < kPeakDistance * reduction_;
    });
    if (!shoulder) apart.push_back(place);
  }
  places.best = std::move(apart);
  return places;
}

}  // namespace orient::exterior
