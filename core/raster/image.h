// A grey image in memory. Pixel convention of the whole project: the outer corner of the upper-left
// pixel is (0, 0), its centre (0.5, 0.5). NaN is "no data".
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

namespace orient {

inline constexpr float kNoData = std::numeric_limits<float>::quiet_NaN();

// Row-major float grey values in the unit of the source (0..255, 0..65535, ...).
struct Image {
  int width = 0;
  int height = 0;
  std::vector<float> values;

  Image() = default;
  Image(int width_px, int height_px, float fill = 0)
      : width(width_px),
        height(height_px),
        values(static_cast<size_t>(width_px) * static_cast<size_t>(height_px), fill) {}

  bool Empty() const { return values.empty(); }
  float& At(int col, int row) { return values[Index(col, row)]; }
  float At(int col, int row) const { return values[Index(col, row)]; }
  const float* Row(int row) const { return values.data() + Index(0, row); }
  float* Row(int row) { return values.data() + Index(0, row); }

 private:
  size_t Index(int col, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(width) + static_cast<size_t>(col);
  }
};

// An image cut out of a raster, perhaps reduced: raster = origin + scale * image (pixel coordinates
// of the convention on both sides, so no half pixels appear).
struct ImageWindow {
  Image image;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // raster pixel of the image's (0, 0)
  double scale = 1;                                  // raster pixels per image pixel

  Eigen::Vector2d RasterFromImage(const Eigen::Vector2d& pixel) const {
    return origin + scale * pixel;
  }
  Eigen::Vector2d ImageFromRaster(const Eigen::Vector2d& pixel) const {
    return (pixel - origin) / scale;
  }
};

struct PixelWindow {
  int col = 0, row = 0, width = 0, height = 0;  // may reach beyond the raster
};

}  // namespace orient
