#include "tools/scan_interior.h"

#include "core/files/results.h"
#include "tools/film_positions.h"
#include "tools/photo_interior.h"

namespace orient {

namespace {

constexpr double kSymbolRadius_mm = 1;  // of one bar or dot

CoveredArea Around(const Eigen::Vector2d& centre_mm, double radius_mm) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(radius_mm);
  return {centre_mm - half, centre_mm + half};
}

}  // namespace

std::vector<CoveredArea> CoveredAreas(const CameraFile& camera, const MarkShapes& marks) {
  std::vector<CoveredArea> areas;
  for (const Fiducial& fiducial : camera.fiducials) {
    const auto shape = marks.find(fiducial.mark);
    if (shape != marks.end())
      areas.push_back(Around(fiducial.position_mm, MarkRadius(shape->second)));
    if (!fiducial.symbol || !fiducial.symbol->at_mm) continue;
    const Eigen::Vector2d step = fiducial.symbol->step_mm.value_or(Eigen::Vector2d::Zero());
    for (int i = 0; i < fiducial.symbol->count; ++i)
      areas.push_back(
          Around(fiducial.position_mm + *fiducial.symbol->at_mm + i * step, kSymbolRadius_mm));
  }
  for (const BorderFeature& feature : camera.border)
    if (feature.shows != BorderSign::kBright) areas.push_back({feature.from_mm, feature.to_mm});
  return areas;
}

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
  interior.failure = WhyOfAnotherScan(result, path, scan.Path(), scan.Width(), scan.Height());
  if (!interior.failure.empty()) return interior;
  interior.weak = result.status == Status::kWeak;
  if (interior.weak) interior.messages.emplace_back("interior orientation is weak");
  interior.negative = result.polarity == Polarity::kNegative;
  interior.positions = FilmPositions(result, camera, marks);
  return interior;
}

}  // namespace orient
