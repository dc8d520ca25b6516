#include "block/inputs/scan_interior.h"

#include "block/inputs/film_positions.h"
#include "block/inputs/photo_interior.h"
#include "core/files/results.h"

namespace orient::block {

namespace {

constexpr double kSymbolRadius_mm = 1;  // of one bar or dot

exterior::CoveredArea Around(const Eigen::Vector2d& centre_mm, double radius_mm) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(radius_mm);
  return {centre_mm - half, centre_mm + half};
}

}  // namespace

std::vector<exterior::CoveredArea> CoveredAreas(const CameraFile& camera,
                                                const interior::MarkShapes& marks) {
  std::vector<exterior::CoveredArea> areas;
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

ScanInterior FilmGeometry(const CameraFile& camera, const interior::MarkShapes& marks,
                          const Raster& scan, const std::string& path) {
  ScanInterior interior;
  const InteriorResult result = ReadInteriorResult(path);
  if (result.status == Status::kFailed || !result.photo_from_pixel) {
    const std::string why = JoinedSentences(result.findings);
    interior.findings = {{.reason = Reason::kInteriorFailed,
                          .at_best = Status::kFailed,
                          .where = why.empty() ? "" : ": " + why}};
    return interior;
  }
  const std::string other =
      WhyOfAnotherScan(result, path, scan.Path(), scan.Width(), scan.Height());
  if (!other.empty()) {
    interior.findings = {
        {.reason = Reason::kInteriorOfAnotherScan, .at_best = Status::kFailed, .where = other}};
    return interior;
  }
  if (result.status == Status::kWeak) interior.findings = {{Reason::kInteriorWeak, Status::kWeak}};
  interior.negative = result.polarity == Polarity::kNegative;
  interior.positions = FilmPositions(result, camera, marks);
  return interior;
}

}  // namespace orient::block
