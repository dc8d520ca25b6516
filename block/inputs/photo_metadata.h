// What a photo's own file says of where it was taken from and how: EXIF, as GDAL reads it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "core/files/orientation_table.h"

namespace orient::block {

struct PhotoMetadata {
  std::optional<Eigen::Vector2d> lon_lat_deg;  // WGS 84
  std::optional<double> altitude_m;            // above sea level
  std::optional<double> focal_length_mm;
};

// Nothing where the file cannot be read, or says nothing; scans of film rarely say anything.
PhotoMetadata ReadPhotoMetadata(const std::string& path);

// "(51) (3) (10.5)" as GDAL writes EXIF's degrees, minutes, seconds; empty where it is no angle.
std::optional<double> DegreesOfTag(const std::string& tag);

// One sigma of a position that a GNSS receiver in a camera found, of a photo that looks down.
Vector6d SigmaOfCameraGnss();

// A position alone, in `crs`, with the accuracy of a GNSS receiver in a camera; empty without
// latitude, longitude or altitude, or where the place has no coordinates in `crs`.
std::optional<OrientationRow> LocatedByMetadata(const std::string& photo,
                                                const PhotoMetadata& metadata, const Crs& crs);

}  // namespace orient::block
