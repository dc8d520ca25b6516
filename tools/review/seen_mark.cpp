#include "tools/review/seen_mark.h"

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "interior/marks/drawing_fit.h"

namespace orient {
namespace {

// The linear part of scan pixels from mm of the photo system, in each way it may be.
std::vector<Eigen::Matrix2d> PixelFromMm(const Raster& scan, const ScanKnowledge& known) {
  if (known.photo_from_pixel) return {known.photo_from_pixel->A.inverse()};
  double pixel_mm = 1e-3 * known.pixel_size_um.value_or(0);
  if (const auto dpi = scan.DpiTag(); dpi && !known.pixel_size_um) pixel_mm = 25.4 / *dpi;
  if (!(pixel_mm > 0)) return {};
  std::vector<Eigen::Matrix2d> ways;
  for (const ScanOrientation orientation : kAllScanOrientations)
    if (known.orientation.value_or(orientation) == orientation)
      ways.emplace_back((PhotoFromPixelAxes(orientation) * pixel_mm).inverse());
  return ways;
}

}  // namespace

std::optional<SeenAtClick> SeeMark(const Raster& scan, const CameraFile& camera,
                                   const ScanKnowledge& known, const std::string& mark,
                                   const Eigen::Vector2d& click) {
  const auto fiducial = std::find_if(camera.fiducials.begin(), camera.fiducials.end(),
                                     [&](const Fiducial& one) { return one.id == mark; });
  if (fiducial == camera.fiducials.end()) return std::nullopt;
  const auto drawing = camera.marks.find(fiducial->mark);
  if (drawing == camera.marks.end() || drawing->second.image) return std::nullopt;
  const std::vector<Eigen::Matrix2d> ways = PixelFromMm(scan, known);
  if (ways.empty()) return std::nullopt;
  interior::CutOptions cut;
  cut.reach_px = 6;
  ImageWindow window;
  interior::SeenMark seen = CutMark(scan, click, ways.front(), cut, &window);
  std::optional<SeenAtClick> best;
  for (const Polarity polarity : {Polarity::kPositive, Polarity::kNegative}) {
    if (polarity == Polarity::kNegative)
      for (float& value : seen.image.values) value = -value;
    if (known.polarity.value_or(polarity) != polarity) continue;
    for (const Eigen::Matrix2d& pixel_from_mm : ways) {
      seen.pixel_from_mm = pixel_from_mm;
      const interior::FittedDrawing found =
          interior::LocateDrawing(drawing->second.elements, {seen});
      const double correlation = found.correlation.at(0);
      const bool compared = correlation >= -1;
      if (compared && (!best || correlation > best->correlation))
        best = SeenAtClick{window.RasterFromImage(found.centre.at(0)), correlation};
    }
  }
  return best;
}

}  // namespace orient
