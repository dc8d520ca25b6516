#include "tools/review/seen_mark.h"

#include <Eigen/LU>
#include <algorithm>

#include "interior/marks/drawing_fit.h"

namespace orient {
namespace {

// The linear part of scan pixels from mm of the photo system.
std::optional<Eigen::Matrix2d> PixelFromMm(const Raster& scan, const InteriorResult* interior) {
  if (interior != nullptr && interior->photo_from_pixel)
    return Eigen::Matrix2d(interior->photo_from_pixel->A.inverse());
  std::optional<double> pixel_mm;
  if (const auto dpi = scan.DpiTag()) pixel_mm = 25.4 / *dpi;
  if (interior != nullptr && interior->pixel_size_um) pixel_mm = 1e-3 * *interior->pixel_size_um;
  if (!pixel_mm || !(*pixel_mm > 0)) return std::nullopt;
  const auto orientation =
      interior != nullptr ? interior->orientation : std::optional<ScanOrientation>();
  const Eigen::Matrix2d axes =
      PhotoFromPixelAxes(orientation.value_or(ScanOrientation::kR0)) * *pixel_mm;
  return Eigen::Matrix2d(axes.inverse());
}

}  // namespace

std::optional<SeenAtClick> SeeMark(const Raster& scan, const CameraFile& camera,
                                   const InteriorResult* interior, const std::string& mark,
                                   const Eigen::Vector2d& click) {
  const auto fiducial = std::find_if(camera.fiducials.begin(), camera.fiducials.end(),
                                     [&](const Fiducial& one) { return one.id == mark; });
  if (fiducial == camera.fiducials.end()) return std::nullopt;
  const auto drawing = camera.marks.find(fiducial->mark);
  const auto pixel_from_mm = PixelFromMm(scan, interior);
  if (drawing == camera.marks.end() || drawing->second.image || !pixel_from_mm) return std::nullopt;
  interior::CutOptions cut;
  cut.reach_px = 6;
  cut.negative = interior != nullptr && interior->polarity == Polarity::kNegative;
  ImageWindow window;
  const interior::SeenMark seen = CutMark(scan, click, *pixel_from_mm, cut, &window);
  const interior::FittedDrawing found = interior::LocateDrawing(drawing->second.elements, {seen});
  return SeenAtClick{window.RasterFromImage(found.centre.at(0)), found.correlation.at(0)};
}

}  // namespace orient
