#include "tools/scan_interior.h"

#include "core/files/results.h"
#include "tools/film_positions.h"
#include "tools/photo_interior.h"

namespace orient {

ScanInterior DigitalGeometry(const Camera& camera, const Raster& raster) {
  ScanInterior interior;
  interior.positions.push_back(
      {PhotoInteriorOf(raster, camera, "").photo_from_pixel, std::nullopt, Matrix6d::Zero(), 0});
  return interior;
}

ScanInterior FilmGeometry(const CameraFile& camera, const MarkShapes& marks, const Raster& scan,
                          const std::string& path) {
  ScanInterior interior;
  const InteriorResult result = ReadInteriorResult(path);
  if (result.status == Status::kFailed || !result.photo_from_pixel) {
    interior.failure = "its interior orientation failed";
    for (const std::string& message : result.messages) interior.failure += ": " + message;
    return interior;
  }
  if (result.width != scan.Width() || result.height != scan.Height()) {
    interior.failure = path + " is of a scan of " + std::to_string(result.width) + " x " +
                       std::to_string(result.height) + " px, " + scan.Path() + " has " +
                       std::to_string(scan.Width()) + " x " + std::to_string(scan.Height()) +
                       "; run 'orient interior' again";
    return interior;
  }
  interior.weak = result.status == Status::kWeak;
  if (interior.weak) interior.messages.emplace_back("interior orientation is weak");
  interior.negative = result.polarity == Polarity::kNegative;
  interior.positions = FilmPositions(result, camera, marks);
  return interior;
}

}  // namespace orient
