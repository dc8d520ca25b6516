// PNG files.
#include <fmt/format.h>

#include <stdexcept>

#include "core/base/atomic_write.h"
#include "core/raster/png_bands.h"
#include "core/raster/raster.h"

namespace orient {
namespace {

// The bands of interleaved values.
std::vector<Image> Bands(int width, int height, int channels,
                         const std::vector<unsigned char>& values) {
  if (width <= 0 || height <= 0 || (channels != 1 && channels != 3) ||
      values.size() !=
          static_cast<size_t>(width) * static_cast<size_t>(height) * static_cast<size_t>(channels))
    throw std::invalid_argument(
        fmt::format("WritePng: the values do not fill {} x {} x {}", width, height, channels));
  std::vector<Image> bands(static_cast<size_t>(channels), Image(width, height));
  for (size_t i = 0; i < values.size(); ++i)
    bands[i % bands.size()].values[i / bands.size()] = static_cast<float>(values[i]);
  return bands;
}

}  // namespace

void WritePng(const std::string& path, int width, int height, int channels,
              const std::vector<unsigned char>& values) {
  const std::vector<unsigned char> png = EncodePngBands(Bands(width, height, channels, values), 8);
  WriteFileAtomically(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

}  // namespace orient
