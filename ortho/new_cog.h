// A Cloud Optimized GeoTIFF in the making.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/raster/band_raster.h"
#include "core/terrain/crs.h"
#include "ortho/map_grid.h"

namespace orient::ortho {

// Written in tiles in any order, from several threads: first uncompressed, then compressed without
// loss with overviews. The file appears whole or not at all. Every failure is an InputError naming
// the path, or an EnvironmentError.
class NewCog {
 public:
  static constexpr int kTile = 512;  // side of its tiles, px; windows best begin at multiples

  NewCog(const std::string& path, const BandFormat& format, const MapGrid& grid, const Crs& crs);
  NewCog(const NewCog&) = delete;
  NewCog& operator=(const NewCog&) = delete;
  ~NewCog();

  // Values of each band, and 0 where the mask is to say that there is no data. What is never
  // written has none.
  void Write(const PixelWindow& window, const std::vector<Image>& values,
             const std::vector<std::uint8_t>& mask);
  // With these entries of metadata; on so many threads; 0: on all cores.
  void Finish(const std::map<std::string, std::string>& metadata, int threads);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// The windows of a grid's tiles, row by row.
std::vector<PixelWindow> TilesOf(const MapGrid& grid);

}  // namespace orient::ortho
