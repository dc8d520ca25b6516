#include "core/base/open_dataset.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <cpl_vsi.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>
#include <vector>

#include "core/base/error.h"
#include "core/base/quiet_gdal.h"
#include "core/base/remote_files.h"

namespace orient {
namespace {

// Formats whose files hold their own pixels.
const std::vector<const char*> kRasterFormats = {
    "GTiff",          "COG",     "PNG",     "JPEG", "JP2OpenJPEG", "JP2ECW",  "JP2KAK",
    "JP2MrSID",       "ECW",     "HFA",     "ENVI", "EHdr",        "AAIGrid", "NITF",
    "GRASSASCIIGrid", "JPEGXL",  "WEBP",    "BMP",  "GIF",         "PNM",     "SGI",
    "MrSID",          "SRTMHGT", "USGSDEM", "DTED", "GTX",         "GSAG",    "GSBG",
    "GS7BG",          "SAGA",    "RST",     "XYZ",  "BT",          "GPKG",    "netCDF",
    "HDF5Image",      "MBTiles", "Zarr"};
const std::vector<const char*> kVectorFormats = {"GPKG",         "ESRI Shapefile",
                                                 "GeoJSON",      "GeoJSONSeq",
                                                 "TopoJSON",     "KML",
                                                 "LIBKML",       "GML",
                                                 "CSV",          "FlatGeobuf",
                                                 "SQLite",       "GPX",
                                                 "MapInfo File", "OpenFileGDB",
                                                 "DXF"};

bool IsFile(const std::string& path) {
  VSIStatBufL info;
  return VSIStatExL(path.c_str(), &info, VSI_STAT_EXISTS_FLAG) == 0;
}

// Whether the user gave XML or a GDAL connection string ("<...>", "PREFIX:...") and not a file.
bool IsInstruction(const std::string& path) {
  return !IsFile(path) && (path.starts_with('<') || path.find(':') != std::string::npos);
}

std::string Extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

GDALDatasetUniquePtr Open(const std::string& name, unsigned kind,
                          const std::vector<const char*>& formats, const char* virtual_format) {
  RegisterGdalDrivers();
  const std::string path = GdalName(name);
  const unsigned flags = kind | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR;
  const auto open = [&](char** drivers) {
    return Watched(
        [&] { return GDALDatasetUniquePtr(GDALDataset::Open(path.c_str(), flags, drivers)); });
  };
  if (IsInstruction(path)) return open(nullptr);
  RequireNoPipe(path);
  CPLStringList drivers;
  for (const char* format : formats) drivers.AddString(format);
  const std::string extension = Extension(path);
  if (extension == ".vrt") drivers.AddString(virtual_format);
  if (extension == ".wms") drivers.AddString("WMS");
  // The GML driver would otherwise download the schema.
  const CPLConfigOptionSetter no_download("GML_DOWNLOAD_SCHEMA", "NO", false);
  return open(drivers.List());
}

}  // namespace

bool IsPipe(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  return std::filesystem::is_fifo(status) || std::filesystem::is_socket(status) ||
         std::filesystem::is_character_file(status);
}

void RequireNoPipe(const std::string& path) {
  if (IsPipe(path)) throw InputError(path + ": is a pipe, a socket or a device; give a file");
}

GDALDatasetUniquePtr OpenRasterDataset(const std::string& path) {
  return Open(path, GDAL_OF_RASTER, kRasterFormats, "VRT");
}

GDALDatasetUniquePtr OpenVectorDataset(const std::string& path) {
  return Open(path, GDAL_OF_VECTOR, kVectorFormats, "OGR_VRT");
}

void RequireSmallBlocks(GDALDataset* dataset, const std::string& path) {
  constexpr double kMostBytes = 256e6;
  const char* interleave = dataset->GetMetadataItem("INTERLEAVE", "IMAGE_STRUCTURE");
  const std::string driver = dataset->GetDriverName();
  const bool whole = driver == "WEBP" || driver == "JPEGXL";  // decoded into memory
  const bool together = whole || (interleave != nullptr && std::string(interleave) == "PIXEL");
  for (int i = 1; i <= dataset->GetRasterCount(); ++i) {
    int width = 0, height = 0;
    GDALRasterBand* band = dataset->GetRasterBand(i);
    band->GetBlockSize(&width, &height);
    if (whole) height = dataset->GetRasterYSize();
    const double bytes = double(width) * height *
                         GDALGetDataTypeSizeBytes(band->GetRasterDataType()) *
                         (together ? dataset->GetRasterCount() : 1);
    if (bytes > kMostBytes)
      throw InputError(fmt::format(
          "{}: is stored in pieces of {} x {} pixels, each {:.0f} MB, and cannot be read in "
          "windows; write it in tiles: gdal_translate -co TILED=YES -co BIGTIFF=IF_SAFER",
          path, width, height, bytes / 1e6));
  }
}

}  // namespace orient
