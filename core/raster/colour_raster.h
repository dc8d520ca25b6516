// Red, green and blue of a raster: for pictures of what was measured in its grey values (Raster).
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/raster/raster.h"

namespace orient {

// Read-only; reading is serialised by an internal lock, so one object may be shared by threads.
class ColourRaster {
 public:
  // Empty where the file has one band only, without a palette of colours. Throws like Raster::Open.
  static std::optional<ColourRaster> Open(const std::string& path);
  ColourRaster(ColourRaster&&) noexcept;
  ColourRaster& operator=(ColourRaster&&) noexcept;
  ~ColourRaster();

  // The three bands of a window; outside the raster NaN. Nodata and masks are Raster's business.
  // Throws InputError naming the path where the file is damaged there.
  std::vector<ImageWindow> Read(const PixelWindow& window) const;

 private:
  struct Impl;
  explicit ColourRaster(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient
