#include "core/raster/band_raster.h"

#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <utility>

#include "core/base/error.h"
#include "core/base/gdal_faults.h"
#include "core/base/open_dataset.h"
#include "core/raster/colour_bands.h"
#include "core/raster/raster.h"
#include "core/raster/reading_errors.h"
#include "core/raster/window_reader.h"

namespace orient {
namespace {

// Number of bands without alpha, which only marks valid pixels.
int CountOfValues(GDALDataset* dataset) {
  const int count = dataset->GetRasterCount();
  const bool alpha =
      count > 1 && dataset->GetRasterBand(count)->GetColorInterpretation() == GCI_AlphaBand;
  return alpha ? count - 1 : count;
}

// The nodata value of each band; empty if a band declares none.
std::vector<float> NodataOf(const std::vector<GDALRasterBand*>& bands) {
  std::vector<float> values;
  for (GDALRasterBand* band : bands) {
    int declared = 0;
    values.push_back(static_cast<float>(band->GetNoDataValue(&declared)));
    if (declared == 0) return {};
  }
  return values;
}

// Offset of the byte after a band's last tile in a TIFF; 0 for other files. GDAL's GTiff manual,
// "Metadata", domain TIFF.
std::int64_t EndOfTiles(GDALRasterBand* band) {
  int width = 1, height = 1;
  band->GetBlockSize(&width, &height);
  const auto number = [&](const char* what, int col, int row) -> std::int64_t {
    const char* text =
        band->GetMetadataItem(fmt::format("{}_{}_{}", what, col, row).c_str(), "TIFF");
    return text == nullptr ? 0 : std::atoll(text);
  };
  std::int64_t end = 0;
  for (int row = 0; row * std::int64_t{height} < band->GetYSize(); ++row)
    for (int col = 0; col * std::int64_t{width} < band->GetXSize(); ++col)
      end = std::max(end, number("BLOCK_OFFSET", col, row) + number("BLOCK_SIZE", col, row));
  return end;
}

void RequireUsable(GDALDataset* dataset, const std::string& path) {
  const GDALDataType type = dataset->GetRasterBand(1)->GetRasterDataType();
  for (int i = 1; i <= dataset->GetRasterCount(); ++i) {
    GDALRasterBand* band = dataset->GetRasterBand(i);
    if (ColourTableOf(dataset, band) != nullptr)
      throw InputError(path + ": has a palette, whose values cannot be interpolated; convert it " +
                       "with gdal_translate -expand rgb (or gray)");
    if (band->GetRasterDataType() != type)
      throw InputError(path + ": its bands are of different types; convert it with gdal_translate");
  }
  if (type != GDT_Byte && type != GDT_UInt16 && type != GDT_Int16 && type != GDT_Float32)
    throw InputError(path + ": holds values of the type " + GDALGetDataTypeName(type) +
                     "; convert it with gdal_translate -ot UInt16 (or Float32)");
}

}  // namespace

bool BandFormat::IsUnsigned() const { return type == GDT_Byte || type == GDT_UInt16; }

struct BandRaster::Impl {
  std::string path;
  mutable std::mutex mutex;  // GDAL datasets are not for two threads at a time
  GDALDatasetUniquePtr dataset;
  BandFormat format;
  bool white_is_zero = false;
  bool has_mask = false;      // one for all bands, alpha too
  std::vector<float> nodata;  // of each band; empty unless all have one
  std::unique_ptr<WindowReader> windows;

  // Closing may report errors, too.
  ~Impl() {
    const ReadingErrors errors;
    windows.reset();
    dataset.reset();
  }

  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError(path + ": cannot be read (" + why +
                     "); the file is damaged or truncated: copy or scan it again");
  }
};

BandRaster::BandRaster(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BandRaster::BandRaster(BandRaster&&) noexcept = default;
BandRaster& BandRaster::operator=(BandRaster&&) noexcept = default;
BandRaster::~BandRaster() = default;

BandRaster BandRaster::Open(const std::string& path) {
  static_cast<void>(Raster::OpenScan(path));  // throws with the reason if it cannot be used
  const ReadingErrors errors;
  const GdalFaults faults;  // GDAL opens masks late and takes one that cannot be opened as absent
  auto impl = std::make_unique<Impl>();
  impl->path = path;
  impl->dataset = OpenRasterDataset(path);
  if (impl->dataset == nullptr) throw InputError(path + ": cannot be opened a second time");
  GDALDataset* dataset = impl->dataset.get();
  RequireUsable(dataset, path);
  GDALRasterBand* first = dataset->GetRasterBand(1);
  const int count = CountOfValues(dataset);
  impl->format = {count, first->GetRasterDataType(), BitsPerSample(first), {}};
  std::vector<GDALRasterBand*> bands;
  for (int i = 1; i <= count; ++i) {
    bands.push_back(dataset->GetRasterBand(i));
    impl->format.colours.push_back(bands.back()->GetColorInterpretation());
  }
  impl->white_is_zero = count == 1 && IsWhiteZero(dataset);
  impl->nodata = NodataOf(bands);
  if (impl->white_is_zero)
    for (float& value : impl->nodata) value = GreatestValue(impl->format.bits) - value;
  impl->has_mask = (first->GetMaskFlags() & GMF_PER_DATASET) != 0;
  impl->windows = std::make_unique<WindowReader>(dataset, bands);
  faults.ThrowIfAny();
  return BandRaster(std::move(impl));
}

int BandRaster::Width() const { return impl_->dataset->GetRasterXSize(); }
int BandRaster::Height() const { return impl_->dataset->GetRasterYSize(); }
const BandFormat& BandRaster::Format() const { return impl_->format; }

std::string BandRaster::Metadata(const std::string& name) const {
  const std::lock_guard lock(impl_->mutex);
  const ReadingErrors errors;
  const char* value = Watched([&] { return impl_->dataset->GetMetadataItem(name.c_str()); });
  return value == nullptr ? std::string() : std::string(value);
}

bool BandRaster::IsWhole() const {
  const std::lock_guard lock(impl_->mutex);
  const ReadingErrors errors;
  VSIStatBufL file;
  if (VSIStatL(impl_->dataset->GetDescription(), &file) != 0) return false;
  GDALRasterBand* band = impl_->dataset->GetRasterBand(1);
  const std::int64_t end =
      Watched([&] { return std::max(EndOfTiles(band), EndOfTiles(band->GetMaskBand())); });
  return end <= static_cast<std::int64_t>(file.st_size);
}

std::vector<Image> BandRaster::Read(const PixelWindow& window) const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<Image> bands;
  for (std::size_t band = 0; band < impl_->format.colours.size(); ++band) {
    Image& image = bands.emplace_back(window.width, window.height);
    if (const auto why = impl_->windows->Read(band, window, image.values.data())) impl_->Fail(*why);
    const float white = GreatestValue(impl_->format.bits);
    if (impl_->white_is_zero)
      for (float& value : image.values) value = white - value;
  }
  return bands;
}

std::vector<Image> BandRaster::ReadWithGaps(const PixelWindow& window) const {
  std::vector<Image> bands = Read(window);
  const std::vector<std::uint8_t> mask =
      impl_->has_mask ? ReadMask(window) : std::vector<std::uint8_t>();
  const std::vector<float>& nodata = impl_->nodata;
  if (mask.empty() && nodata.empty()) return bands;
  for (std::size_t i = 0; i < bands.front().values.size(); ++i) {
    // The nodata value in one band is a colour; only in all bands it is no data.
    const bool gap = !nodata.empty() && std::equal(bands.begin(), bands.end(), nodata.begin(),
                                                   [i](const Image& image, float nothing) {
                                                     return image.values[i] == nothing;
                                                   });
    if (!gap && (mask.empty() || mask[i] != 0)) continue;
    for (Image& image : bands) image.values[i] = kNoData;
  }
  return bands;
}

std::vector<std::uint8_t> BandRaster::ReadMask(const PixelWindow& window) const {
  const std::lock_guard lock(impl_->mutex);
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(window.width) *
                                 static_cast<std::size_t>(window.height));
  const ReadingErrors errors;
  GDALRasterBand* band = Watched([&] { return impl_->dataset->GetRasterBand(1)->GetMaskBand(); });
  if (const auto why = ReadWindow(band, window, mask.data(), GDT_Byte)) impl_->Fail(*why);
  return mask;
}

}  // namespace orient
