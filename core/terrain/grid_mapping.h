// From ground coordinates (block CRS) to the node coordinates of a DEM, which may lie in any CRS.
// Used by GroundSurface.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "core/geometry/bounds.h"
#include "core/geometry/transform2d.h"

namespace orient {

// Immutable and safe to use from several threads, which PROJ's transforms are not: a curved mapping
// is tabulated once, densely enough that cubic interpolation stays below kTableError_m.
class GridMapping {
 public:
  static constexpr double kTableError_m = 1e-4;

  // DEM and block share their CRS.
  explicit GridMapping(const Affine2d& node_from_block) : affine_(node_from_block) {}

  // Tabulates `exact` over `region`. Empty where no table of reasonable size is accurate enough.
  // `exact` may be empty (no value) at some places: they have no nodes.
  using Exact = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>;
  static std::optional<GridMapping> Tabulate(const Exact& exact, const Bounds& region);

  // NaN where the mapping is not defined.
  Eigen::Vector2d NodeFromBlock(double x_m, double y_m) const {
    return table_.empty() ? affine_ * Eigen::Vector2d(x_m, y_m) : Interpolate(x_m, y_m);
  }

  // Pieces of a straight line on the ground of this length are straight among the nodes, to
  // kTableError_m. Infinite where DEM and block share their CRS.
  double StraightLength() const { return straight_length_m_; }

  // Ground area of a cell at a point, square root: its size in metres.
  double CellSizeAt(double x_m, double y_m) const;

  // Distance in metres, due east from a point, to the next row or column of nodes.
  double CellAlongXAt(double x_m, double y_m) const;

 private:
  GridMapping() = default;
  Eigen::Vector2d Interpolate(double x_m, double y_m) const;
  double TableError(const Exact& exact) const;
  void FindStraightLength();

  Affine2d affine_;
  std::vector<Eigen::Vector2d> table_;  // row by row, from (west_, south_) to the north
  int columns_ = 0, rows_ = 0;
  double west_ = 0, south_ = 0, step_m_ = 1;
  Bounds region_;
  double straight_length_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace orient
