// Windowed reading of any raster GDAL opens: 8/16 bit, float, grey, RGB, palette, /vsi paths.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// Read-only; reading is serialised by an internal lock, so one object may be shared by threads.
class Raster {
 public:
  // Throws InputError naming the path: missing, not an image, no bands, in tiles or strips too
  // large for reading windows; EnvironmentError where the machine cannot read it.
  static Raster Open(const std::string& path);
  // A photo's scan: also throws where the file declares a size that no scan has, or far more pixels
  // than it has bytes.
  static Raster OpenScan(const std::string& path);
  Raster(Raster&&) noexcept;
  Raster& operator=(Raster&&) noexcept;
  ~Raster();

  int Width() const;
  int Height() const;
  int Bands() const;
  int BitsPerSample() const;
  const std::string& Path() const;
  // col,row -> x,y: x = g[0] + g[1] col + g[2] row, y = g[3] + g[4] col + g[5] row.
  std::optional<std::array<double, 6>> GeoTransform() const;
  std::string CrsWkt() const;            // empty where the file has none
  std::optional<double> DpiTag() const;  // mean of x and y where a resolution tag is present

  // Grey values (for RGB and palette: 0.299 R + 0.587 G + 0.114 B) of a window, `reduction` >= 1
  // raster pixels per image pixel in both directions, area-averaged; overviews are used where they
  // are at least as fine as asked (averaged ones, or the decoder's own: nearest-neighbour overviews
  // lie up to half a raster pixel a level off). Outside the raster, and where all bands hold nodata
  // or the mask says so: NaN; a reduced pixel needs half of its area to be valid. The image covers
  // the window from its outer corner; a linear ramp stays exactly that ramp at every reduction.
  // Throws InputError naming path and window when the file is damaged there.
  ImageWindow ReadGrey(const PixelWindow& window, double reduction = 1) const;
  ImageWindow ReadGrey() const;  // all of it

 private:
  struct Impl;
  explicit Raster(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Writes 8-bit grey or RGB PNG (1 or 3 interleaved channels). For pictures. Throws like
// WriteFileAtomically.
void WritePng(const std::string& path, int width, int height, int channels,
              const std::vector<unsigned char>& values);

}  // namespace orient
