#include "block/inputs/photo_metadata.h"

#include <gdal_priv.h>

#include <cmath>
#include <numbers>
#include <sstream>
#include <vector>

#include "core/base/open_dataset.h"
#include "core/base/quiet_gdal.h"
#include "core/geometry/rotation.h"

namespace orient::block {
namespace {

// Single-frequency receivers, and altitudes of whatever datum.
constexpr double kPositionSigma_m = 15, kAltitudeSigma_m = 40;
const double kTiltSigma_rad = RadFromDeg(3);

// All numbers of a tag, whatever stands between them.
std::vector<double> NumbersOf(std::string tag) {
  for (char& c : tag)
    if (c == '(' || c == ')' || c == ',') c = ' ';
  std::istringstream text(tag);
  std::vector<double> numbers;
  for (double value = 0; text >> value;) numbers.push_back(value);
  if (!text.eof()) return {};
  return numbers;
}

class Tags {
 public:
  explicit Tags(const std::string& path) : dataset_(OpenRasterDataset(path)) {}

  // GDAL's TIFF driver keeps EXIF apart, that for JPEG does not.
  std::string Find(const char* name) {
    for (const char* domain : {"EXIF", ""}) {
      const char* tag = dataset_ ? dataset_->GetMetadataItem(name, domain) : nullptr;
      if (tag != nullptr) return tag;
    }
    return "";
  }

  std::optional<double> FindNumber(const char* name) {
    const std::vector<double> numbers = NumbersOf(Find(name));
    if (numbers.size() != 1 || !std::isfinite(numbers[0])) return std::nullopt;
    return numbers[0];
  }

 private:
  GDALDatasetUniquePtr dataset_;
};

}  // namespace

std::optional<double> DegreesOfTag(const std::string& tag) {
  const std::vector<double> parts = NumbersOf(tag);
  if (parts.empty() || parts.size() > 3) return std::nullopt;
  double degrees = 0, unit = 1;
  for (const double part : parts) {
    if (!(part >= 0)) return std::nullopt;
    degrees += part * unit;
    unit /= 60;
  }
  if (degrees > 180) return std::nullopt;
  return degrees;
}

PhotoMetadata ReadPhotoMetadata(const std::string& path) {
  RegisterGdalDrivers();
  const QuietGdal quiet;
  Tags tags(path);
  PhotoMetadata metadata;
  const auto latitude = DegreesOfTag(tags.Find("EXIF_GPSLatitude"));
  const auto longitude = DegreesOfTag(tags.Find("EXIF_GPSLongitude"));
  const std::string north_south = tags.Find("EXIF_GPSLatitudeRef");
  const std::string east_west = tags.Find("EXIF_GPSLongitudeRef");
  const bool south = north_south.starts_with("S"), west = east_west.starts_with("W");
  const bool complete = (south || north_south.starts_with("N")) &&
                        (west || east_west.starts_with("E")) &&
                        !tags.Find("EXIF_GPSStatus").starts_with("V");  // void: no fix
  // Receivers without a fix write zeros, too.
  if (complete && latitude && longitude && *latitude <= 90 && (*latitude > 0 || *longitude > 0)) {
    metadata.lon_lat_deg.emplace(west ? -*longitude : *longitude, south ? -*latitude : *latitude);
  }
  metadata.altitude_m = tags.FindNumber("EXIF_GPSAltitude");
  const std::string reference = tags.Find("EXIF_GPSAltitudeRef");
  if (metadata.altitude_m && (reference == "1" || reference == "01" || reference == "0x01"))
    *metadata.altitude_m *= -1;  // below the sea
  metadata.focal_length_mm = tags.FindNumber("EXIF_FocalLength");
  if (metadata.focal_length_mm && !(*metadata.focal_length_mm > 0))
    metadata.focal_length_mm.reset();
  quiet.ThrowFaults();
  return metadata;
}

Vector6d SigmaOfCameraGnss() {
  Vector6d sigma;
  sigma << kPositionSigma_m, kPositionSigma_m, kAltitudeSigma_m, kTiltSigma_rad, kTiltSigma_rad,
      std::numbers::pi;
  return sigma;
}

std::optional<OrientationRow> LocatedByMetadata(const std::string& photo,
                                                const PhotoMetadata& metadata, const Crs& crs) {
  if (!metadata.lon_lat_deg || !metadata.altitude_m) return std::nullopt;
  const auto xy = CoordinateTransform::Between(crs.Wkt(), "EPSG:4326")(*metadata.lon_lat_deg);
  if (!xy) return std::nullopt;
  OrientationRow row;
  row.photo = photo;
  row.pose.position_m << *xy, *metadata.altitude_m;
  row.attitude_known = false;
  row.sigma = SigmaOfCameraGnss();
  return row;
}

}  // namespace orient::block
