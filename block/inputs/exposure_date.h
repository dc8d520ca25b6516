// When a photo was taken, as far as its file says.
#pragma once

#include <optional>
#include <string>

#include "core/geometry/camera.h"

namespace orient::block {

// ISO 8601 date from EXIF's DateTimeOriginal, else TIFF's DateTime. Empty for film: a scan's
// dates are those of scanning. Empty if the file has no date, or an impossible one.
std::optional<std::string> ExposureDate(const std::string& path, CameraKind kind);

// "1998:07:30 11:02:45" as EXIF and TIFF write it; empty where it is no date.
std::optional<std::string> DateOfTag(const std::string& tag);

}  // namespace orient::block
