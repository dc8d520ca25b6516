// Pictures inside report.html.
#pragma once

#include <optional>
#include <string>

namespace orient {

struct InlinePicture {
  std::string data_uri;
  int width = 0, height = 0;  // px of the original; of a map as it is shown
};

// Small PNG files go in as they are, large ones smaller and as JPEG, so that a report of many
// photos can still be mailed. GeoTIFFs, as which mosaics are written, go in reduced
// and as JPEG, white where they have no data. Empty where the file cannot be read as a picture.
std::optional<InlinePicture> LoadPicture(const std::string& path);

}  // namespace orient
