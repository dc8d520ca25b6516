// The new photo's grey values at any reduction: small levels whole and once, large ones by window.
#pragma once

#include <Eigen/Core>
#include <map>
#include <mutex>

#include "core/raster/image.h"
#include "core/raster/raster.h"

namespace orient::exterior {

// Refers to the raster, which must outlive it. Safe to use from several threads.
class PhotoImage {
 public:
  // A negative is turned into a positive by the sign of its grey values; correlation does not care
  // about their offset.
  PhotoImage(const Raster& raster, bool negative) : raster_(raster), negative_(negative) {}

  int Width() const { return raster_.Width(); }
  int Height() const { return raster_.Height(); }

  // Grey values around a scan pixel, at least `half_px` scan pixels to every side, at `reduction`
  // scan pixels per image pixel. Outside the scan: NaN.
  ImageWindow Around(const Eigen::Vector2d& centre_px, const Eigen::Vector2d& half_px,
                     int reduction) const;

 private:
  const Image& Level(int reduction) const;  // the whole photo at a reduction, read once

  const Raster& raster_;
  bool negative_;
  mutable std::mutex mutex_;
  mutable std::map<int, Image> levels_;
};

// The least reduction at which the whole photo has at most so many pixels.
int FinestReduction(const PhotoImage& photo, double most_pixels);

}  // namespace orient::exterior
