#include "block/inputs/exposure_date.h"

#include <fmt/format.h>
#include <gdal_priv.h>

#include <cstdio>

#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"

namespace orient::block {

std::optional<std::string> DateOfTag(const std::string& tag) {
  constexpr int kFirstAerialPhoto = 1858, kLastYear = 2200;
  int year = 0, month = 0, day = 0;
  if (std::sscanf(tag.c_str(), "%4d:%2d:%2d", &year, &month, &day) != 3 &&
      std::sscanf(tag.c_str(), "%4d-%2d-%2d", &year, &month, &day) != 3)
    return std::nullopt;
  if (year < kFirstAerialPhoto || year > kLastYear || month < 1 || month > 12 || day < 1 ||
      day > 31)
    return std::nullopt;
  return fmt::format("{:04}-{:02}-{:02}", year, month, day);
}

std::optional<std::string> ExposureDate(const std::string& path, CameraKind kind) {
  if (kind == CameraKind::kFilm) return std::nullopt;
  const QuietGdal quiet;
  const GDALDatasetUniquePtr dataset = OpenRasterDataset(path);
  std::optional<std::string> date;
  // GDAL's TIFF driver keeps EXIF apart, that for JPEG does not.
  for (const auto& [name, domain] :
       {std::pair("EXIF_DateTimeOriginal", "EXIF"), std::pair("EXIF_DateTimeOriginal", ""),
        std::pair("TIFFTAG_DATETIME", "")}) {
    const char* tag = dataset && !date ? dataset->GetMetadataItem(name, domain) : nullptr;
    if (tag != nullptr) date = DateOfTag(tag);
  }
  quiet.ThrowFaults();
  return date;
}

}  // namespace orient::block
