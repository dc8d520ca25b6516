#include "patchdb/candidates.h"

#include "core/imaging/interest_points.h"

namespace orient {
namespace {

constexpr int kOverlap = 24;  // px around a tile, so that its border has interest points too

// Only strength decides within a cell; a weak point may be the best of a weak area.
InterestOptions PointOptions() {
  InterestOptions options;
  options.min_weight_ratio = 0.1;
  return options;
}

void Insert(const InterestCandidate& candidate, double cell_m, int per_cell, CandidateGrid& grid) {
  const CellIndex index(static_cast<std::int64_t>(std::floor(-candidate.ground_m.y() / cell_m)),
                        static_cast<std::int64_t>(std::floor(candidate.ground_m.x() / cell_m)));
  std::vector<InterestCandidate>& cell = grid.cells[index];
  const auto weaker = std::find_if(cell.begin(), cell.end(), [&](const InterestCandidate& other) {
    return other.weight < candidate.weight;
  });
  cell.insert(weaker, candidate);
  if (static_cast<int>(cell.size()) > per_cell) cell.pop_back();
  ++grid.count;
}

// `core` is the tile without its border: neighbours must not find one point twice.
void SearchTile(const Raster& raster, const SourceView& source, const PixelWindow& core,
                double cell_m, int per_cell, CandidateGrid& grid) {
  const ImageWindow tile = raster.ReadGrey({core.col - kOverlap, core.row - kOverlap,
                                            core.width + 2 * kOverlap, core.height + 2 * kOverlap});
  for (const InterestPoint& point : FindInterestPoints(tile.image, PointOptions())) {
    const Eigen::Vector2d pixel = tile.RasterFromImage(point.pixel);
    if (pixel.x() < core.col || pixel.y() < core.row || pixel.x() >= core.col + core.width ||
        pixel.y() >= core.row + core.height)
      continue;
    const auto ground = source.GroundFromPixel(pixel);
    if (ground) Insert({pixel, *ground, point.weight, point.roundness}, cell_m, per_cell, grid);
  }
}

}  // namespace

CandidateGrid FindInterestCandidates(const Raster& raster, const SourceView& source, double cell_m,
                                     int per_cell, int tile_px,
                                     const std::function<void(int, int)>& progress) {
  CandidateGrid grid;
  const int cols = (raster.Width() + tile_px - 1) / tile_px;
  const int tiles = cols * ((raster.Height() + tile_px - 1) / tile_px);
  for (int tile = 0; tile < tiles; ++tile) {
    const int row = tile / cols * tile_px, col = tile % cols * tile_px;
    SearchTile(raster, source,
               {col, row, std::min(tile_px, raster.Width() - col),
                std::min(tile_px, raster.Height() - row)},
               cell_m, per_cell, grid);
    if (progress) progress(tile + 1, tiles);
  }
  return grid;
}

}  // namespace orient
