#include "ortho/new_cog.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal_priv.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <optional>

#include "core/base/new_file.h"
#include "core/base/quiet_gdal.h"

namespace orient::ortho {
namespace {

GDALDriver* DriverOf(const char* name) {
  RegisterGdalDrivers();
  return GetGDALDriverManager()->GetDriverByName(name);
}

GDALDatasetUniquePtr MakeStage(const std::string& path, const BandFormat& format,
                               const MapGrid& grid, const Crs& crs) {
  const std::string side = std::to_string(NewCog::kTile);
  CPLStringList options;
  options.SetNameValue("TILED", "YES");
  options.SetNameValue("BLOCKXSIZE", side.c_str());
  options.SetNameValue("BLOCKYSIZE", side.c_str());
  options.SetNameValue("INTERLEAVE", "BAND");
  options.SetNameValue("SPARSE_OK", "TRUE");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  const auto type = static_cast<GDALDataType>(format.type);
  if (format.bands == 3) options.SetNameValue("PHOTOMETRIC", "RGB");
  GDALDatasetUniquePtr made(DriverOf("GTiff")->Create(path.c_str(), grid.width, grid.height,
                                                      format.bands, type, options.List()));
  if (!made) return made;
  std::array<double, 6> transform = grid.GeoTransform();
  made->SetGeoTransform(transform.data());
  made->SetProjection(crs.Wkt().c_str());
  for (int band = 1; band <= format.bands && format.bands != 3; ++band)
    made->GetRasterBand(band)->SetColorInterpretation(
        static_cast<GDALColorInterp>(format.colours[static_cast<std::size_t>(band - 1)]));
  const CPLConfigOptionSetter internal("GDAL_TIFF_INTERNAL_MASK", "YES", false);
  if (made->CreateMaskBand(GMF_PER_DATASET) != CE_None) return nullptr;
  return made;
}

}  // namespace

struct NewCog::Impl {
  NewFile target, stage;
  GDALDatasetUniquePtr made;
  std::mutex mutex;  // guards `made`: a GDAL dataset is for one thread at a time

  explicit Impl(const std::string& path) : target(path), stage(path) {}
  ~Impl() {
    const QuietGdal quiet;
    made.reset();
  }
  // GDAL may not report a fault of the machine by its return value.
  void Require(bool done, const QuietGdal& quiet) const {
    quiet.ThrowFaults();
    if (!done) target.Fail("GDAL failed" + quiet.Message());
  }
};

NewCog::NewCog(const std::string& path, const BandFormat& format, const MapGrid& grid,
               const Crs& crs)
    : impl_(std::make_unique<Impl>(path)) {
  const QuietGdal quiet;
  impl_->made = MakeStage(impl_->stage.PartialPath(), format, grid, crs);
  impl_->Require(impl_->made != nullptr, quiet);
}

NewCog::~NewCog() = default;

void NewCog::Write(const PixelWindow& window, const std::vector<Image>& values,
                   const std::vector<std::uint8_t>& mask) {
  const std::lock_guard lock(impl_->mutex);
  const QuietGdal quiet;
  const auto write = [&](GDALRasterBand* band, const void* from, GDALDataType type) {
    // GDAL only reads what it is given to write.
    impl_->Require(band->RasterIO(GF_Write, window.col, window.row, window.width, window.height,
                                  const_cast<void*>(from), window.width, window.height, type, 0, 0,
                                  nullptr) == CE_None,
                   quiet);
  };
  for (std::size_t band = 0; band < values.size(); ++band)
    write(impl_->made->GetRasterBand(static_cast<int>(band) + 1), values[band].values.data(),
          GDT_Float32);
  write(impl_->made->GetRasterBand(1)->GetMaskBand(), mask.data(), GDT_Byte);
}

void NewCog::Finish(const std::map<std::string, std::string>& metadata, int threads) {
  const QuietGdal quiet;
  for (const auto& [name, value] : metadata)
    impl_->made->SetMetadataItem(name.c_str(), value.c_str());
  impl_->made->FlushCache();
  impl_->Require(CPLGetLastErrorType() < CE_Failure, quiet);
  CPLStringList options;
  options.SetNameValue("COMPRESS", "DEFLATE");
  options.SetNameValue("PREDICTOR", "YES");
  options.SetNameValue("BLOCKSIZE", std::to_string(kTile).c_str());
  options.SetNameValue("OVERVIEW_RESAMPLING", "AVERAGE");
  options.SetNameValue("BIGTIFF", "IF_SAFER");
  options.SetNameValue("NUM_THREADS", threads > 0 ? std::to_string(threads).c_str() : "ALL_CPUS");
  GDALDatasetUniquePtr cog(DriverOf("COG")->CreateCopy(impl_->target.PartialPath().c_str(),
                                                       impl_->made.get(), FALSE, options.List(),
                                                       nullptr, nullptr));
  const bool made = cog != nullptr;
  cog.reset();  // writes the rest
  impl_->made.reset();
  impl_->Require(made && CPLGetLastErrorType() < CE_Failure, quiet);
  impl_->target.Keep();
}

std::vector<PixelWindow> TilesOf(const MapGrid& grid) {
  std::vector<PixelWindow> tiles;
  for (int row = 0; row < grid.height; row += NewCog::kTile)
    for (int col = 0; col < grid.width; col += NewCog::kTile)
      tiles.push_back({col, row, std::min(NewCog::kTile, grid.width - col),
                       std::min(NewCog::kTile, grid.height - row)});
  return tiles;
}

}  // namespace orient::ortho
