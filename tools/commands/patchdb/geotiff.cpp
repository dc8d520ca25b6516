#include "tools/commands/patchdb/geotiff.h"

#include <gdal_priv.h>

#include "core/base/new_file.h"
#include "core/base/quiet_gdal.h"

namespace orient {
namespace {

GDALDataType TypeOf(int bits) {
  if (bits == 8) return GDT_Byte;
  return bits == 16 ? GDT_UInt16 : GDT_Float32;
}

bool Write(const std::string& path, const GeoTiff& raster, const Crs& crs) {
  GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
  if (driver == nullptr) return false;
  const char* const options[] = {"COMPRESS=DEFLATE", nullptr};
  const GDALDatasetUniquePtr file(driver->Create(path.c_str(), raster.width, raster.height,
                                                 static_cast<int>(raster.bands.size()),
                                                 TypeOf(raster.bits), const_cast<char**>(options)));
  if (file == nullptr) return false;
  double transform[6] = {raster.origin_m.x(), raster.pixel_m, 0, raster.origin_m.y(), 0,
                         -raster.pixel_m};
  if (file->SetGeoTransform(transform) != CE_None ||
      file->SetProjection(crs.Wkt1().c_str()) != CE_None)
    return false;
  for (std::size_t i = 0; i < raster.bands.size(); ++i) {
    std::vector<float> values = raster.bands[i].values;
    if (raster.bits != 32)
      for (float& value : values)
        if (std::isnan(value)) value = 0;
    if (file->GetRasterBand(static_cast<int>(i) + 1)
            ->RasterIO(GF_Write, 0, 0, raster.width, raster.height, values.data(), raster.width,
                       raster.height, GDT_Float32, 0, 0) != CE_None)
      return false;
  }
  file->FlushCache();
  return CPLGetLastErrorType() != CE_Failure;
}

}  // namespace

void WriteGeoTiff(const std::string& path, const GeoTiff& raster, const Crs& crs) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  NewFile file(path);
  if (!Write(file.PartialPath(), raster, crs))
    file.Fail("GDAL failed" + quiet.Message() + "; check that its folder is writable");
  file.Keep();
}

}  // namespace orient
