#include "core/raster/colour_raster.h"

#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/gdal_faults.h"
#include "core/base/open_dataset.h"
#include "core/raster/colour_bands.h"
#include "core/raster/reading_errors.h"
#include "core/raster/window_reader.h"

namespace orient {
namespace {

constexpr std::size_t kColours = 3;
using PaletteColour = std::array<float, kColours>;

std::vector<PaletteColour> PaletteOf(GDALRasterBand* band) {
  std::vector<PaletteColour> palette;
  const GDALColorTable* table = band->GetColorTable();
  for (int i = 0; table != nullptr && i < table->GetColorEntryCount(); ++i) {
    const GDALColorEntry* entry = table->GetColorEntry(i);
    palette.push_back({static_cast<float>(entry->c1), static_cast<float>(entry->c2),
                       static_cast<float>(entry->c3)});
  }
  const bool grey = std::all_of(palette.begin(), palette.end(), [](const PaletteColour& colour) {
    return colour[0] == colour[1] && colour[1] == colour[2];
  });
  if (grey) palette.clear();
  return palette;
}

}  // namespace

struct ColourRaster::Impl {
  std::string path;
  mutable std::mutex mutex;  // GDAL datasets are not for two threads at a time
  GDALDatasetUniquePtr dataset;
  std::vector<PaletteColour> palette;

  std::unique_ptr<WindowReader> windows;  // of the bands

  Image ReadBand(std::size_t band, const PixelWindow& inside) const {
    Image values(inside.width, inside.height);
    const auto why_not = windows->Read(band, inside, values.values.data());
    if (!why_not) return values;
    throw InputError(path + ": cannot read its colours (" + *why_not +
                     "); the file is damaged or truncated: copy or scan it again");
  }

  std::vector<Image> ReadColours(const PixelWindow& inside) const {
    std::vector<Image> colours;
    if (palette.empty()) {
      for (std::size_t i = 0; i < kColours; ++i) colours.push_back(ReadBand(i, inside));
      return colours;
    }
    const Image indices = ReadBand(0, inside);
    colours.assign(kColours, Image(inside.width, inside.height, kNoData));
    for (std::size_t i = 0; i < indices.values.size(); ++i) {
      const auto index = static_cast<std::size_t>(std::max(0.0f, indices.values[i]));
      for (std::size_t colour = 0; index < palette.size() && colour < kColours; ++colour)
        colours[colour].values[i] = palette[index][colour];
    }
    return colours;
  }
};

ColourRaster::ColourRaster(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
ColourRaster::ColourRaster(ColourRaster&&) noexcept = default;
ColourRaster& ColourRaster::operator=(ColourRaster&&) noexcept = default;
ColourRaster::~ColourRaster() = default;

std::optional<ColourRaster> ColourRaster::Open(const std::string& path) {
  static_cast<void>(Raster::Open(path));  // throws with the reason if it cannot be used
  const ReadingErrors errors;
  const GdalFaults faults;
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->dataset = OpenRasterDataset(path);
  if (impl->dataset == nullptr) throw InputError(path + ": cannot be opened a second time");
  const std::vector<GDALRasterBand*> bands = ColourBands(impl->dataset.get());
  if (bands.size() < kColours) impl->palette = PaletteOf(bands[0]);
  faults.ThrowIfAny();
  if (bands.size() < kColours && impl->palette.empty()) return std::nullopt;
  impl->windows = std::make_unique<WindowReader>(impl->dataset.get(), bands);
  return ColourRaster(std::move(impl));
}

std::vector<ImageWindow> ColourRaster::Read(const PixelWindow& window) const {
  const std::lock_guard lock(impl_->mutex);
  ImageWindow nothing;
  nothing.image = Image(window.width, window.height, kNoData);
  nothing.origin = Eigen::Vector2d(window.col, window.row);
  std::vector<ImageWindow> parts(kColours, nothing);
  const int left = std::max(window.col, 0), top = std::max(window.row, 0);
  const PixelWindow inside{
      left, top, std::min(window.col + window.width, impl_->dataset->GetRasterXSize()) - left,
      std::min(window.row + window.height, impl_->dataset->GetRasterYSize()) - top};
  if (inside.width <= 0 || inside.height <= 0) return parts;
  const std::vector<Image> colours = impl_->ReadColours(inside);
  for (std::size_t colour = 0; colour < kColours; ++colour)
    for (int row = 0; row < inside.height; ++row)
      std::copy_n(colours[colour].Row(row), inside.width,
                  parts[colour].image.Row(top - window.row + row) + (left - window.col));
  return parts;
}

}  // namespace orient
