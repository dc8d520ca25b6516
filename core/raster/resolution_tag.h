// The resolution that an image file states. Internal to core/imaging.
#pragma once

#include <optional>
#include <string>

class GDALDataset;

namespace orient {

// Dots per inch, mean of x and y: TIFF or EXIF tags, else JFIF's density, else PNG's pHYs. Empty
// where absent, without a unit or not positive.
std::optional<double> ReadDpiTag(GDALDataset* dataset, const std::string& path);

}  // namespace orient
