#include "core/terrain/dem_raster.h"

#include <fmt/format.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string_view>

#include "core/base/environment_error.h"
#include "core/base/error.h"
#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/base/trimmed.h"
#include "core/geometry/ground_height.h"
#include "core/terrain/crs.h"

namespace orient {
namespace {

bool IsMetre(std::string unit) {
  std::transform(unit.begin(), unit.end(), unit.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const std::string_view name = Trimmed(unit);
  return name.empty() || name == "m" || name == "metre" || name == "metres" || name == "meter" ||
         name == "meters";
}

// Throws InputError unless the band's values, scaled, are heights in metres.
void RequireMetres(GDALRasterBand* band, const std::string& path) {
  const std::string unit = band->GetUnitType();
  if (!IsMetre(unit))
    throw InputError(path + ": the heights of the DEM are in '" + unit +
                     "', not in metres; convert them, for example with gdal_calc.py, or, if they " +
                     "are in metres, correct their unit with gdal_edit.py -units m");
  const double scale = band->GetScale(), offset = band->GetOffset();
  if (!std::isfinite(scale) || scale == 0 || !std::isfinite(offset))
    throw InputError(fmt::format(
        "{}: the DEM's scale is {} and its offset {}: its values give no heights; correct them "
        "with gdal_edit.py -scale and -offset",
        path, scale, offset));
}

}  // namespace

struct DemRaster::Impl {
  GDALDatasetUniquePtr dataset;
  GDALRasterBand* band = nullptr;
};

DemRaster::DemRaster(const std::string& path) : path_(path), impl_(std::make_unique<Impl>()) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  impl_->dataset = OpenRasterDataset(path);
  if (!impl_->dataset)
    throw InputError(path + ": the DEM cannot be opened" + quiet.Message() +
                     "; name a raster of ground heights that GDAL reads");
  double g[6] = {};
  const bool placed = impl_->dataset->GetGeoTransform(g) == CE_None;
  Affine2d dem_from_corner;
  dem_from_corner.A << g[1], g[2], g[4], g[5];
  dem_from_corner.t << g[0], g[3];
  if (!placed || !dem_from_corner.IsInvertible())
    throw InputError(path +
                     ": the DEM has no georeference; write one, for example with "
                     "gdal_translate -a_ullr");
  const OGRSpatialReference* crs = impl_->dataset->GetSpatialRef();
  quiet.ThrowFaults();
  if (crs == nullptr) ThrowIfOutOfResources();
  if (crs == nullptr)
    throw InputError(path + ": the DEM has no CRS; write it, for example with gdal_edit.py -a_srs");
  const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
  char* wkt = nullptr;
  if (crs->exportToWkt(&wkt, options) == OGRERR_NONE) wkt_ = wkt;
  CPLFree(wkt);
  node_from_dem_ = dem_from_corner.Inverse();
  node_from_dem_.t -= Eigen::Vector2d(0.5, 0.5);

  if (impl_->dataset->GetRasterCount() < 1)
    throw InputError(path + ": the DEM has no band of heights");
  if (impl_->dataset->GetRasterBand(1)->GetColorInterpretation() == GCI_RedBand)
    throw InputError(path + ": is a picture in colours; a DEM has one band of heights in metres");
  RequireSmallBlocks(impl_->dataset.get(), path);
  impl_->band = impl_->dataset->GetRasterBand(1);
  RequireMetres(impl_->band, path);
  quiet.ThrowFaults();
  RequireHeightsInMetres(wkt_, path);
}

DemRaster::~DemRaster() = default;

int DemRaster::Columns() const { return impl_->dataset->GetRasterXSize(); }
int DemRaster::Rows() const { return impl_->dataset->GetRasterYSize(); }

std::vector<std::uint8_t> DemRaster::MaskOf(int column, int row, int columns, int rows) const {
  const QuietGdal quiet;
  const int kind = Watched([&] { return impl_->band->GetMaskFlags(); });
  if ((kind & GMF_PER_DATASET) == 0) return {};
  std::vector<std::uint8_t> mask(static_cast<std::size_t>(columns) *
                                 static_cast<std::size_t>(rows));
  const CPLErr result = Watched([&] {
    return impl_->band->GetMaskBand()->RasterIO(GF_Read, column, row, columns, rows, mask.data(),
                                                columns, rows, GDT_Byte, 0, 0);
  });
  if (result != CE_None)
    throw InputError(fmt::format("{}: its mask cannot be read{}; the file may be damaged", path_,
                                 quiet.Message()));
  return mask;
}

std::vector<float> DemRaster::Read(int column, int row, int columns, int rows) const {
  const QuietGdal quiet;
  constexpr std::size_t kMostNodes = std::size_t{1} << 30;
  const std::size_t size = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
  if (size > kMostNodes)
    throw InputError(fmt::format(
        "{}: {} x {} heights do not fit into memory; cut the DEM to the block or coarsen it", path_,
        columns, rows));
  std::vector<float> heights(size);
  const CPLErr result = Watched([&] {
    return impl_->band->RasterIO(GF_Read, column, row, columns, rows, heights.data(), columns, rows,
                                 GDT_Float32, 0, 0);
  });
  if (result != CE_None)
    throw InputError(fmt::format("{}: the heights cannot be read{}; the file may be damaged", path_,
                                 quiet.Message()));
  const std::vector<std::uint8_t> shown = MaskOf(column, row, columns, rows);
  for (std::size_t i = 0; i < shown.size(); ++i)
    if (shown[i] == 0) heights[i] = std::numeric_limits<float>::quiet_NaN();
  int has_nodata = 0;
  const float nodata = static_cast<float>(impl_->band->GetNoDataValue(&has_nodata));
  const double scale = impl_->band->GetScale(), offset = impl_->band->GetOffset();
  quiet.ThrowFaults();  // GDAL reads the DEM's side files late
  for (float& height : heights) {
    if ((has_nodata != 0 && height == nodata) || !std::isfinite(height))
      height = std::numeric_limits<float>::quiet_NaN();
    else if (scale != 1 || offset != 0)
      height = static_cast<float>(scale * height + offset);
    // -9999, -32768 or 3.4e38 mark voids even if no nodata value is declared.
    if (!CanBeGround(height)) height = std::numeric_limits<float>::quiet_NaN();
  }
  return heights;
}

}  // namespace orient
