// Heights of a grid too large for memory, read tile by tile when they are asked for. Used by
// DemGrid.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace orient {

// Heights of the four nodes around a cell: upper left, upper right, lower left, lower right.
using CellHeights = std::array<float, 4>;

// Reads `columns` x `rows` nodes, row by row; called by one thread at a time. What it throws comes
// out of the question that made it necessary.
using ReadHeights = std::function<std::vector<float>(int column, int row, int columns, int rows)>;

// Keeps the tiles that were used last, 64 MB of them, and for every thread the one it used last.
// Safe to use from several threads.
class DemTiles {
 public:
  DemTiles(ReadHeights read, int columns, int rows);
  CellHeights Cell(int column, int row) const;
  // All heights once, in pieces.
  void VisitAll(const std::function<void(const std::vector<float>&)>& visit) const;

 private:
  struct Tile {
    int columns = 0;  // nodes: those of the next tile's first column and row, too
    std::vector<float> heights;
  };
  using TileIndex = std::pair<int, int>;  // row, column
  struct Kept {
    std::shared_ptr<const Tile> tile;
    std::list<TileIndex>::iterator use;
  };
  // What a thread looked at last, of any of these objects.
  struct LastUsed {
    std::uint64_t owner = 0;
    TileIndex index;
    std::shared_ptr<const Tile> tile;
  };
  std::shared_ptr<const Tile> Find(const TileIndex& index) const;

  ReadHeights read_;
  int columns_, rows_;
  std::uint64_t id_;
  mutable std::mutex mutex_;
  mutable std::map<TileIndex, Kept> kept_;
  mutable std::list<TileIndex> uses_;  // the last one first
};

}  // namespace orient
