// A grid of heights in its own node coordinates, and rays through it. Used by GroundSurface.
//
// Node (column, row) of the grid lies at (u, v) = (column, row); between four nodes the surface is
// bilinear. A cell with a node without height has no surface.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "core/terrain/dem_tiles.h"

namespace orient {

// A straight piece of a ray in node coordinates, for t in [begin, end].
struct GridRay {
  double u, v, z;     // at t = 0
  double du, dv, dz;  // per t; dz <= 0
  double begin, end;
};

class DemGrid {
 public:
  // Row by row; NaN where there is no height. At least 2 x 2 nodes.
  DemGrid(std::vector<float> heights, int columns, int rows);
  // The same grid, of which parts are read when they are needed; all of it once, for its extremes.
  DemGrid(ReadHeights read, int columns, int rows);

  int Columns() const { return columns_; }
  int Rows() const { return rows_; }
  // Over the nodes with heights; NaN where there are none.
  double Min() const { return min_; }
  double Max() const { return max_; }
  double Mean() const { return mean_; }

  std::optional<double> HeightAt(double u, double v) const;

  // Where the ray was when a piece of it ended: a hit only counts where it came from above.
  enum class Side { kUnknown, kAbove, kBelow };

  // The t of the first point where the ray comes down through the surface. `side` carries what is
  // known from the piece before to the piece behind; kBelow (the ray came out of a hole or from
  // outside under the surface: the ground that hides it is not known) ends the search.
  std::optional<double> Trace(const GridRay& ray, Side* side) const;

 private:
  struct Walk;
  std::optional<double> TraceCell(const GridRay& ray, const Walk& walk, double t_exit,
                                  Side* side) const;
  CellHeights Cell(int column, int row) const;

  std::vector<float> heights_;       // of a grid in memory
  std::unique_ptr<DemTiles> tiles_;  // of another one
  int columns_, rows_;
  double min_, max_, mean_;
};

}  // namespace orient
