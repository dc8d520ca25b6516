// Opening files of GDAL's formats. How a file is read follows from its name, the user's word, and
// not from its content alone: a text named photo.tif cannot make the program read the network or
// other files (VRT, WMS). Only for .cpp files that use GDAL.
#pragma once

#include <gdal_priv.h>

#include <string>

namespace orient {

// Read-only, by drivers whose files hold their own pixels or features; VRT and WMS by the file's
// extension. A GDAL connection string that is not a file ("WMS:...", "GPKG:a.gpkg:b") is opened by
// any driver. Null if it cannot be opened; GDAL's last error says why. Throws EnvironmentError
// if the machine is at fault.
GDALDatasetUniquePtr OpenRasterDataset(const std::string& path);
GDALDatasetUniquePtr OpenVectorDataset(const std::string& path);

// A pipe, a socket or a device: reading one that nobody writes to would never end.
bool IsPipe(const std::string& path);
// Throws InputError where it is.
void RequireNoPipe(const std::string& path);

// GDAL reads whole tiles and strips, and whole images of some formats. Throws InputError with the
// remedy where one takes more than 256 MB.
void RequireSmallBlocks(GDALDataset* dataset, const std::string& path);

}  // namespace orient
