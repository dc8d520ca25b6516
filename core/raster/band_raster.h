// All bands of a raster with their own values: for what makes rasters of rasters. Grey values to
// measure in are Raster's business.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// What a copy of a raster's pixels must have in common with it.
struct BandFormat {
  int bands = 1;
  int type = 1;              // GDALDataType: Byte, UInt16, Int16 or Float32
  int bits = 8;              // used of an unsigned value
  std::vector<int> colours;  // GDALColorInterp of each band

  bool IsUnsigned() const;  // from 0 to the greatest value of its bits
  bool operator==(const BandFormat&) const = default;
};

// Read-only; reading is serialised by an internal lock, so one object may be shared by threads.
class BandRaster {
 public:
  // Throws as Raster::OpenScan, and InputError for a palette and for values that a float does not
  // hold.
  static BandRaster Open(const std::string& path);
  BandRaster(BandRaster&&) noexcept;
  BandRaster& operator=(BandRaster&&) noexcept;
  ~BandRaster();

  int Width() const;
  int Height() const;
  const BandFormat& Format() const;
  // Of the file itself ("ORIENT_GSD_M"); empty where it has none of that name.
  std::string Metadata(const std::string& name) const;

  // Whether the file is as long as its tiles say; true where it is no TIFF.
  bool IsWhole() const;

  // The bands of a window inside the raster; where a file says that 0 is white, its values are
  // turned so that 0 is black. Throws InputError naming the path where the file is damaged there.
  std::vector<Image> Read(const PixelWindow& window) const;
  // The same with kNoData where an alpha band, a mask, or nodata values in all bands say that there
  // is nothing.
  std::vector<Image> ReadWithGaps(const PixelWindow& window) const;

  // 0 where the raster's mask says that there is no data, row by row.
  std::vector<std::uint8_t> ReadMask(const PixelWindow& window) const;

 private:
  struct Impl;
  explicit BandRaster(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace orient
