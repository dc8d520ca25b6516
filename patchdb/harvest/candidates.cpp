#include "patchdb/harvest/candidates.h"

#include <algorithm>

#include "core/base/side_by_side.h"
#include "core/matching/interest_points.h"
#include "patchdb/harvest/undeclared_void.h"

namespace orient::patchdb {
namespace {

constexpr int kTilesAtOnce = 8;
constexpr int kOverlap = 24;  // px around a tile, so that its border has interest points too

// Only strength decides within a cell; a weak point may be the best of a weak area.
InterestOptions PointOptions() {
  InterestOptions options;
  options.min_weight_ratio = 0.1;
  return options;
}

void Insert(const InterestCandidate& candidate, const CandidateSearch& search,
            CandidateGrid& grid) {
  std::vector<InterestCandidate>& cell =
      grid.cells[CellOf(candidate.ground_m.head<2>(), search.cell_m)];
  const auto weaker = std::find_if(cell.begin(), cell.end(), [&](const InterestCandidate& other) {
    return other.weight < candidate.weight;
  });
  cell.insert(weaker, candidate);
  if (static_cast<int>(cell.size()) > search.per_cell) cell.pop_back();
  ++grid.count;
}

// Treats undeclared voids as declared, so that there are no points on their borders: these would be
// the strongest of their cells but give no patch.
void DeclareVoids(int bits, Image* grey) {
  if (!(ShareNearEnds(*grey, bits) > 0)) return;
  const std::vector<std::uint8_t> voids = UndeclaredVoids(*grey, bits);
  for (std::size_t i = 0; i < voids.size(); ++i)
    if (voids[i] != 0) grey->values[i] = kNoData;
}

// `core` is the tile without its border: neighbours must not find one point twice.
std::vector<InterestCandidate> SearchTile(const Raster& raster, const SourceView& source,
                                          const PixelWindow& core, const CandidateSearch& search) {
  const int overlap = kOverlap * search.reduction;
  ImageWindow tile = raster.ReadGrey(
      {core.col - overlap, core.row - overlap, core.width + 2 * overlap, core.height + 2 * overlap},
      search.reduction);
  DeclareVoids(raster.BitsPerSample(), &tile.image);
  std::vector<InterestCandidate> found;
  for (const InterestPoint& point : FindInterestPoints(tile.image, PointOptions())) {
    const Eigen::Vector2d pixel = tile.RasterFromImage(point.pixel);
    if (pixel.x() < core.col || pixel.y() < core.row || pixel.x() >= core.col + core.width ||
        pixel.y() >= core.row + core.height)
      continue;
    const auto ground = source.GroundFromPixel(pixel);
    if (!ground || (search.wanted && !search.wanted(*ground))) continue;
    found.push_back({pixel, *ground, point.weight, point.roundness});
  }
  return found;
}

}  // namespace

CellIndex CellOf(const Eigen::Vector2d& ground_m, double cell_m) {
  return {static_cast<std::int64_t>(std::floor(-ground_m.y() / cell_m)),
          static_cast<std::int64_t>(std::floor(ground_m.x() / cell_m))};
}

CandidateGrid FindInterestCandidates(const Raster& raster, const SourceView& source,
                                     const CandidateSearch& search,
                                     const std::function<void(int, int)>& progress) {
  CandidateGrid grid;
  const int side = search.tile_px * search.reduction;
  const int cols = (raster.Width() + side - 1) / side;
  const int tiles = cols * ((raster.Height() + side - 1) / side);
  for (int first = 0; first < tiles; first += kTilesAtOnce) {
    const int count = std::min(kTilesAtOnce, tiles - first);
    std::vector<std::vector<InterestCandidate>> found(static_cast<std::size_t>(count));
    SideBySide(found.size(), [&](std::size_t i) {
      const int tile = first + static_cast<int>(i);
      const int row = tile / cols * side, col = tile % cols * side;
      found[i] = SearchTile(
          raster, source,
          {col, row, std::min(side, raster.Width() - col), std::min(side, raster.Height() - row)},
          search);
    });
    for (const auto& of_tile : found) {
      for (const InterestCandidate& candidate : of_tile) Insert(candidate, search, grid);
    }
    if (progress) progress(first + count, tiles);
  }
  return grid;
}

}  // namespace orient::patchdb
