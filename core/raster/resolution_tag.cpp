#include "core/raster/resolution_tag.h"

#include <cpl_vsi.h>
#include <gdal_priv.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

namespace orient {
namespace {

constexpr double kCmPerInch = 2.54;
constexpr double kMetrePerInch = 0.0254;

std::optional<double> Positive(double dpi) {
  if (dpi > 0 && dpi < 1e6) return dpi;
  return std::nullopt;
}

// "300" or "(300)"; unit "2" or "2 (pixels/inch)", 3: pixels/cm.
std::optional<double> FromTags(GDALDataset* dataset, const std::string& prefix,
                               const std::string& unit_name) {
  const char* x = dataset->GetMetadataItem((prefix + "XResolution").c_str());
  const char* y = dataset->GetMetadataItem((prefix + "YResolution").c_str());
  const char* unit = dataset->GetMetadataItem(unit_name.c_str());
  if (x == nullptr || y == nullptr || unit == nullptr) return std::nullopt;
  const auto number = [](std::string_view text) {
    text.remove_prefix(std::min(text.find_first_not_of(" (+"), text.size()));
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
  };
  const double mean = (number(x) + number(y)) / 2;
  const int code = std::atoi(unit);
  if (code == 2) return Positive(mean);
  if (code == 3) return Positive(mean * kCmPerInch);
  return std::nullopt;
}

std::vector<uint8_t> FileStart(const std::string& path) {
  std::vector<uint8_t> bytes(4096);
  VSILFILE* file = VSIFOpenL(path.c_str(), "rb");
  if (file == nullptr) return {};
  bytes.resize(VSIFReadL(bytes.data(), 1, bytes.size(), file));
  VSIFCloseL(file);
  return bytes;
}

uint32_t BigEndian(const uint8_t* bytes, int count) {
  uint32_t value = 0;
  for (int i = 0; i < count; ++i) value = (value << 8) | bytes[i];
  return value;
}

// APP0 directly after the start of image, as the JFIF standard demands.
std::optional<double> FromJfif(const std::vector<uint8_t>& start) {
  if (start.size() < 18 || start[0] != 0xff || start[1] != 0xd8 || start[3] != 0xe0)
    return std::nullopt;
  if (std::memcmp(start.data() + 6, "JFIF", 5) != 0) return std::nullopt;
  const double mean = (BigEndian(&start[14], 2) + BigEndian(&start[16], 2)) / 2.0;
  if (start[13] == 1) return Positive(mean);
  if (start[13] == 2) return Positive(mean * kCmPerInch);
  return std::nullopt;
}

std::optional<double> FromPng(const std::vector<uint8_t>& start) {
  if (start.size() < 8 || std::memcmp(start.data(), "\x89PNG\r\n\x1a\n", 8) != 0)
    return std::nullopt;
  for (size_t at = 8; at + 8 + 9 <= start.size();) {
    const size_t length = BigEndian(&start[at], 4);
    if (std::memcmp(&start[at + 4], "pHYs", 4) == 0 && length == 9) {
      const uint8_t* data = &start[at + 8];
      const double per_metre = (double(BigEndian(data, 4)) + double(BigEndian(data + 4, 4))) / 2;
      return data[8] == 1 ? Positive(per_metre * kMetrePerInch) : std::nullopt;
    }
    at += length + 12;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> ReadDpiTag(GDALDataset* dataset, const std::string& path) {
  if (const auto tiff = FromTags(dataset, "TIFFTAG_", "TIFFTAG_RESOLUTIONUNIT")) return tiff;
  const std::string driver = dataset->GetDriverName();
  if (driver == "JPEG") {
    if (const auto jfif = FromJfif(FileStart(path))) return jfif;
    return FromTags(dataset, "EXIF_", "EXIF_ResolutionUnit");
  }
  if (driver == "PNG") return FromPng(FileStart(path));
  return std::nullopt;
}

}  // namespace orient
