#include "core/raster/raster.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <fmt/format.h>
#include <gdal_priv.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/raster/grey_reader.h"
#include "core/raster/reading_errors.h"
#include "core/raster/resolution_tag.h"

namespace orient {

struct Raster::Impl {
  Impl(std::string name, GDALDatasetUniquePtr opened)
      : path(std::move(name)), dataset(std::move(opened)), grey(dataset.get(), path) {}
  // Closing may report errors, too.
  ~Impl() {
    const ReadingErrors errors;
    dataset.reset();
  }

  std::string path;
  mutable std::mutex mutex;  // GDAL datasets are not for two threads at a time
  GDALDatasetUniquePtr dataset;
  GreyReader grey;
};

Raster::Raster(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Raster::Raster(Raster&&) noexcept = default;
Raster& Raster::operator=(Raster&&) noexcept = default;
Raster::~Raster() = default;

Raster Raster::Open(const std::string& path) {
  RegisterGdalDrivers();
  const ReadingErrors errors;
  // Reads only the window's part of uncompressed rows; by default GDAL reads whole rows.
  const CPLConfigOptionSetter direct("GTIFF_DIRECT_IO", "YES", true);
  GDALDatasetUniquePtr dataset = OpenRasterDataset(path);
  if (dataset == nullptr) {
    ThrowIfOutOfResources();
    VSIStatBufL info;
    if (VSIStatExL(path.c_str(), &info, VSI_STAT_EXISTS_FLAG) != 0)
      throw InputError(path + ": no such image; check the path");
    if (access(path.c_str(), R_OK) != 0 && errno == EACCES)
      throw InputError(path + ": may not be read by you; ask for permission to read it");
    throw InputError(path + ": not an image that GDAL can read (" + errors.Message() +
                     "); convert it to TIFF or copy it again");
  }
  if (dataset->GetRasterCount() == 0)
    throw InputError(path + ": holds no image bands; name one of its subdatasets instead");
  RequireSmallBlocks(dataset.get(), path);
  const GdalFaults faults;  // overviews and masks are opened when they are asked for
  auto impl = std::make_unique<Impl>(path, std::move(dataset));
  faults.ThrowIfAny();
  return Raster(std::move(impl));
}

Raster Raster::OpenScan(const std::string& path) {
  constexpr int kLongestSide = 300000;  // 1.5 m of film at 5 um
  constexpr double kMostPixels = 1e10;
  constexpr double kManyPixels = 1e8;          // fewer are read quickly
  constexpr double kMostPixelsPerByte = 4000;  // compression of an image of one grey value
  Raster scan = Open(path);
  const double pixels = double(scan.Width()) * scan.Height();
  if (std::max(scan.Width(), scan.Height()) > kLongestSide || pixels > kMostPixels)
    throw InputError(
        fmt::format("{}: declares {} x {} pixels, more than the scan of a photo has; check the "
                    "file, or cut the photo out of it",
                    path, scan.Width(), scan.Height()));
  VSIStatBufL info;
  const bool is_file = VSIStatL(path.c_str(), &info) == 0 &&
                       scan.impl_->dataset->GetDriverName() != std::string("VRT");
  if (is_file && pixels > kManyPixels && pixels > kMostPixelsPerByte * double(info.st_size))
    throw InputError(
        fmt::format("{}: declares {} x {} pixels but has {} bytes; the file is damaged or "
                    "empty: copy or scan it again",
                    path, scan.Width(), scan.Height(), static_cast<long long>(info.st_size)));
  return scan;
}

int Raster::Width() const { return impl_->dataset->GetRasterXSize(); }
int Raster::Height() const { return impl_->dataset->GetRasterYSize(); }
int Raster::Bands() const { return impl_->dataset->GetRasterCount(); }
const std::string& Raster::Path() const { return impl_->path; }

int Raster::BitsPerSample() const {
  const std::lock_guard lock(impl_->mutex);
  GDALRasterBand* band = impl_->dataset->GetRasterBand(1);
  const char* bits = band->GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
  if (bits != nullptr && std::atoi(bits) > 0) return std::atoi(bits);
  return GDALGetDataTypeSizeBits(band->GetRasterDataType());
}

std::optional<std::array<double, 6>> Raster::GeoTransform() const {
  const std::lock_guard lock(impl_->mutex);
  const ReadingErrors errors;
  std::array<double, 6> g{};
  const CPLErr result = Watched([&] { return impl_->dataset->GetGeoTransform(g.data()); });
  if (result != CE_None) return std::nullopt;
  return g;
}

std::string Raster::CrsWkt() const {
  const std::lock_guard lock(impl_->mutex);
  const ReadingErrors errors;
  const char* wkt = Watched([&] { return impl_->dataset->GetProjectionRef(); });
  return wkt == nullptr ? std::string() : std::string(wkt);
}

std::optional<double> Raster::DpiTag() const {
  const std::lock_guard lock(impl_->mutex);
  const ReadingErrors errors;
  return Watched([&] { return ReadDpiTag(impl_->dataset.get(), impl_->path); });
}

ImageWindow Raster::ReadGrey(const PixelWindow& window, double reduction) const {
  if (window.width <= 0 || window.height <= 0)
    throw std::invalid_argument(fmt::format("ReadGrey: the window of {} is empty", Path()));
  if (!(reduction >= 1))
    throw std::invalid_argument(fmt::format("ReadGrey: a reduction of {} is below 1", reduction));
  constexpr double kMostCells = 1 << 27;
  if (window.width / reduction * (window.height / reduction) > kMostCells)
    throw InputError(fmt::format("{}: {} x {} pixels do not fit into memory at once; cut it",
                                 Path(), window.width, window.height));
  const std::lock_guard lock(impl_->mutex);
  return impl_->grey.Read(window, reduction);
}

ImageWindow Raster::ReadGrey() const { return ReadGrey({0, 0, Width(), Height()}); }

}  // namespace orient
