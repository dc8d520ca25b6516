// Small north-up rasters with a CRS: density maps, chips.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/raster/image.h"
#include "core/terrain/crs.h"

namespace orient {

struct GeoTiff {
  int width = 0, height = 0;
  int bits = 8;                                        // 8, 16: whole numbers; 32: float
  std::vector<Image> bands;                            // NaN is written as nodata: 0, of floats NaN
  Eigen::Vector2d origin_m = Eigen::Vector2d::Zero();  // outer corner of the upper-left pixel
  double pixel_m = 1;
};

// Deflated; written beside and renamed. Throws InputError naming the path where it cannot be
// written.
void WriteGeoTiff(const std::string& path, const GeoTiff& raster, const Crs& crs);

}  // namespace orient
