// Tiled TIFF files of the simulator, written beside and renamed.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/terrain/crs.h"

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

// A tiled TIFF of which only parts are written; what is left out takes no room and reads as 0.
class SparseTiff {
 public:
  struct Shape {
    int width = 0, height = 0, bands = 1, bits = 8;
  };
  // Throws InputError naming the path, as all of it does.
  SparseTiff(const std::string& path, const Shape& shape, double pixel_size_mm);
  SparseTiff(const SparseTiff&) = delete;
  SparseTiff& operator=(const SparseTiff&) = delete;
  ~SparseTiff();

  // `values`: the bands of a pixel follow each other.
  void Write(const Eigen::Vector2i& origin, const Eigen::Vector2i& size,
             const std::vector<std::uint16_t>& values);
  void Finish();  // the file appears under its name

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

// One float32 band with a georeference.
void WriteFloatTiff(const std::string& path, int width, int height,
                    const std::vector<float>& values, const GeoReference& reference);

}  // namespace orient::simulation
