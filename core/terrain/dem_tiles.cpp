#include "core/terrain/dem_tiles.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace orient {
namespace {

constexpr int kTileCells = 512;         // a side; 1 MB
constexpr std::size_t kMostTiles = 64;  // kept at a time

// Objects are identified by a unique number, as an address may be reused.
std::uint64_t NextId() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

}  // namespace

DemTiles::DemTiles(ReadHeights read, int columns, int rows)
    : read_(std::move(read)), columns_(columns), rows_(rows), id_(NextId()) {}

std::shared_ptr<const DemTiles::Tile> DemTiles::Find(const TileIndex& index) const {
  const std::lock_guard lock(mutex_);
  if (const auto found = kept_.find(index); found != kept_.end()) {
    uses_.splice(uses_.begin(), uses_, found->second.use);
    return found->second.tile;
  }
  const int row = index.first * kTileCells, column = index.second * kTileCells;
  auto tile = std::make_shared<Tile>();
  tile->columns = std::min(kTileCells + 1, columns_ - column);
  tile->heights = read_(column, row, tile->columns, std::min(kTileCells + 1, rows_ - row));
  if (kept_.size() >= kMostTiles) {
    kept_.erase(uses_.back());
    uses_.pop_back();
  }
  uses_.push_front(index);
  kept_[index] = {tile, uses_.begin()};
  return tile;
}

CellHeights DemTiles::Cell(int column, int row) const {
  thread_local LastUsed last;
  const TileIndex index(row / kTileCells, column / kTileCells);
  if (last.owner != id_ || last.index != index) last = {id_, index, Find(index)};
  const Tile& tile = *last.tile;
  const float* upper = tile.heights.data() +
                       static_cast<std::ptrdiff_t>(row % kTileCells) * tile.columns +
                       column % kTileCells;
  const float* lower = upper + tile.columns;
  return {upper[0], upper[1], lower[0], lower[1]};
}

void DemTiles::VisitAll(const std::function<void(const std::vector<float>&)>& visit) const {
  for (int row = 0; row < rows_; row += kTileCells)
    for (int column = 0; column < columns_; column += kTileCells) {
      const std::lock_guard lock(mutex_);
      visit(read_(column, row, std::min(kTileCells, columns_ - column),
                  std::min(kTileCells, rows_ - row)));
    }
}

}  // namespace orient
