// Heights of the ground over a region: bilinear between the nodes of a DEM, in the block's CRS.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/bounds.h"
#include "core/geometry/collinearity.h"
#include "core/terrain/crs.h"

namespace orient {

// Immutable after construction and safe to use from several threads. Nodata (NaN or the raster's
// own value) and points beyond the outermost nodes have no height.
class GroundSurface {
 public:
  // Reads the part of a raster that covers `bounds` (block CRS, grown by a cell or two); without
  // bounds all of it. A DEM in another CRS is used through the transform of every point, exact
  // to 0.1 mm; heights are taken as they are, in metres. Throws InputError: not readable, no
  // georeference, no overlap with bounds, or block_crs is nowhere true to scale in that part.
  static GroundSurface FromFile(const std::string& path, const Crs& block_crs,
                                const std::optional<Bounds>& bounds = std::nullopt);

  // A grid in memory, north up: heights(row, col), row 0 in the north; (west, north) is the outer
  // corner of the upper-left cell, nodes lie in the cells' centres (as in a GeoTIFF).
  static GroundSurface FromGrid(const Eigen::MatrixXf& heights_m, double west_m, double north_m,
                                double cell_m);

  GroundSurface(GroundSurface&&) noexcept;
  GroundSurface& operator=(GroundSurface&&) noexcept;
  ~GroundSurface();

  std::optional<double> HeightAt(double x_m, double y_m) const;

  // First intersection of a ray with the surface, cell by cell in closed form (no cell is skipped),
  // exact to 1e-4 m where the DEM has another CRS. Empty where the ray leaves the DEM, crosses only
  // nodata, points up, starts below the ground, or comes out of a hole or from outside the DEM
  // below the ground: what hides it there is not known.
  std::optional<Eigen::Vector3d> Intersect(const Ray& ray) const;

  double MinHeight() const;
  double MaxHeight() const;
  double MeanHeight() const;
  double CellSize() const;  // metres in the block's CRS
  // How far a cell reaches along a line to the east, metres: less than its size where cells are not
  // square.
  double CellAlongX() const;
  Bounds Extent() const;  // of the loaded nodes, block CRS

 private:
  struct Impl;
  explicit GroundSurface(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient
