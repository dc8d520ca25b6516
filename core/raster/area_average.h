// Area averaging along one axis, for reductions by any factor. Internal to core/imaging.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// What one cell of the reduced axis takes from the pixels of the source axis. The weights of a cell
// inside the source sum up to 1, of one that reaches beyond it to less.
struct CellWeights {
  int first = 0;
  std::vector<double> weights;
};

// Cell k covers [origin + k * size, origin + (k + 1) * size) of a source axis with pixels [i, i+1),
// i in [0, source_count); size >= 1. A pixel that is cut by the cell's border counts with its
// part's area, its value interpolated to that part's centre: the weights' first moment is the
// cell's centre, so that a linear ramp stays exactly that ramp for fractional sizes too.
std::vector<CellWeights> AreaWeights(double origin, double size, int cell_count, int source_count);

// Averages rows as they come, top to bottom, none left out. NaN takes no part.
class AreaAverager {
 public:
  // Column weights for rows that begin at source column `first_col`; row weights likewise count
  // from the source axis' zero.
  AreaAverager(std::vector<CellWeights> cols, std::vector<CellWeights> rows, int first_col);

  // Adds source row `row`: pointer to the value of column `first_col`.
  void AddRow(int row, const float* values);
  // Means where at least `min_share` of the cell's area (or of its part inside the source, with
  // `inside_only`) was valid, NaN elsewhere.
  Image Result(double min_share, bool inside_only) const;

 private:
  // A row of cells of which not all source rows have come: weighted sums down the source's columns.
  struct OpenRow {
    size_t row = 0;
    Eigen::ArrayXf sum;
    Eigen::ArrayXd share;  // empty while all was valid: then it is `weight` everywhere
    double weight = 0;
  };

  static void Add(double weight, const Eigen::Map<const Eigen::ArrayXf>& values, bool gaps,
                  OpenRow* open);
  void Close(const OpenRow& open);

  std::vector<CellWeights> cols_, rows_;
  int first_col_, width_;
  std::vector<double> col_shares_;  // of each column of cells: what lies inside the source
  // Of all columns of cells, zeros behind those that have fewer than the most.
  std::vector<float> weights_;
  size_t most_weights_ = 0;
  std::vector<double> sum_, share_;  // of the result's cells
  std::vector<OpenRow> open_;
  size_t next_row_ = 0;  // the first one not opened yet
};

}  // namespace orient
