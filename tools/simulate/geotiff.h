// Tiled TIFF files of the simulator, written beside and renamed.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/crs.h"

namespace orient::simulation {

struct GeoReference {
  double west_m = 0, north_m = 0, cell_m = 1;
  Crs crs;
};

// One band of grey values, 8 or 16 bit; `pixel_size_mm` becomes the resolution tags, where given.
// Throws InputError naming the path.
void WriteGreyTiff(const std::string& path, int width, int height,
                   const std::vector<std::uint16_t>& values, int bits,
                   const std::optional<double>& pixel_size_mm,
                   const std::optional<GeoReference>& reference);

// One float32 band with a georeference.
void WriteFloatTiff(const std::string& path, int width, int height,
                    const std::vector<float>& values, const GeoReference& reference);

}  // namespace orient::simulation
