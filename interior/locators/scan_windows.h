// Windows of a scan, each read once however often it is looked at.
#pragma once

#include <map>
#include <mutex>
#include <tuple>

#include "core/raster/raster.h"

namespace orient::interior {

// May be shared by threads; windows stay in memory as long as the object.
class ScanWindows {
 public:
  explicit ScanWindows(const Raster& scan) : scan_(scan) {}

  // A reduction below 1, one over a whole number, enlarges: strokes of a pixel look different
  // wherever they lie in the grid, and interpolated ones the same.
  const ImageWindow& Read(const PixelWindow& window, double reduction);
  const Raster& Scan() const { return scan_; }

 private:
  using Key = std::tuple<int, int, int, int, double>;

  const Raster& scan_;
  std::mutex mutex_;
  std::map<Key, ImageWindow> read_;
};

}  // namespace orient::interior
