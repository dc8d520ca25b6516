// Reading the heights of a DEM raster through GDAL. Used by GroundSurface.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/transform2d.h"

namespace orient {

// An open DEM. Every failure is an InputError that names the file. Not thread-safe.
class DemRaster {
 public:
  explicit DemRaster(const std::string& path);
  ~DemRaster();

  int Columns() const;
  int Rows() const;
  const std::string& Wkt() const { return wkt_; }  // of its CRS, with a vertical part if it has one
  // Node coordinates (the centre of the upper-left cell is 0, 0) from the DEM's own CRS.
  const Affine2d& NodeFromDem() const { return node_from_dem_; }

  // The nodes of a window; nodata, NaN and what a mask or an alpha band hides come as NaN, as do
  // values that no ground has (below -1000 m, above 10,000 m): voids whose value is not declared.
  std::vector<float> Read(int column, int row, int columns, int rows) const;

 private:
  struct Impl;
  // 0 where there is nothing; empty where the DEM has neither mask nor alpha band.
  std::vector<std::uint8_t> MaskOf(int column, int row, int columns, int rows) const;

  std::string path_;
  std::unique_ptr<Impl> impl_;
  std::string wkt_;
  Affine2d node_from_dem_;
};

}  // namespace orient
