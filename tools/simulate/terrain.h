// The bare ground of a simulated block: a DEM whose bilinear surface is the truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "core/terrain/ground_surface.h"

namespace orient::simulation {

struct TerrainOptions {
  double mean_height_m = 250;
  double relief_m = 60;  // highest minus lowest node
  double cell_m = 5;
  std::uint32_t seed = 1;
  double longest_wave_m = 1400;  // of the hills
};

// Heights at the centres of cells, north up: row 0 in the north; (west, north) is the outer corner
// of the upper-left cell, as in a GeoTIFF.
class Terrain {
 public:
  // Fractal heights over `extent` (block CRS, m), grown to whole cells.
  static Terrain Make(const Bounds& extent, const TerrainOptions& options);
  Terrain(Eigen::MatrixXf heights_m, double west_m, double north_m, double cell_m);

  // Bilinear between cell centres; positions beyond the outermost centres take the nearest height.
  double HeightAt(double x_m, double y_m) const { return Bilinear(heights_, x_m, y_m); }

  // Light received from the sun relative to flat ground, smooth over the cells' borders.
  // `sun` points to the sun (unit length, east north up).
  Eigen::MatrixXf Shading(const Eigen::Vector3d& sun) const;
  // Any grid with this terrain's nodes, interpolated as HeightAt does.
  double Bilinear(const Eigen::MatrixXf& grid, double x_m, double y_m) const;

  double MaxSlope() const;  // steepest rise between neighbouring nodes, m per m
  double MinHeight() const { return static_cast<double>(heights_.minCoeff()); }
  double MaxHeight() const { return static_cast<double>(heights_.maxCoeff()); }

  const Eigen::MatrixXf& Heights() const { return heights_; }
  double West() const { return west_; }
  double North() const { return north_; }
  double Cell() const { return cell_; }

 private:
  Eigen::MatrixXf heights_;
  double west_, north_, cell_;
};

}  // namespace orient::simulation
