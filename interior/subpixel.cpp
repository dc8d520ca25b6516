#include "interior/subpixel.h"

#include <Eigen/LU>

#include "core/imaging/least_squares_matching.h"
#include "interior/match_precision.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// From the widest to the sharpest: the wide one pulls in from afar, each starts where the last one
// ended.
constexpr std::array<double, 6> kBlurs = {2.6, 1.8, 1.3, 0.95, 0.7, 0.5};

// The matching takes no gradient from the template's outermost pixels.
constexpr double kGradientPx = 3;

ImageWindow ReadAround(const Raster& scan, const Vector2d& centre, double reach_px) {
  const int half = static_cast<int>(std::ceil(reach_px));
  const int col = static_cast<int>(std::floor(centre.x()));
  const int row = static_cast<int>(std::floor(centre.y()));
  return scan.ReadGrey({col - half, row - half, 2 * half + 1, 2 * half + 1});
}

// Bright strokes are what the template shows.
void MakePositive(Image* image, Polarity polarity) {
  if (polarity == Polarity::kPositive) return;
  for (float& value : image->values) value = -value;
}

// The scan around the mark; farther pixels are not part of the match.
Image CutOut(const Image& seen, const MarkShape& shape, const Matrix2d& mm_from_pixel,
             const Vector2d& centre, double margin_mm) {
  Image cut(seen.width, seen.height, kNoData);
  const double radius = MarkRadius(shape);
  for (int row = 0; row < seen.height; ++row) {
    for (int col = 0; col < seen.width; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - centre);
      const double distance =
          shape.picture ? mm.norm() - radius : StrokeDistance(shape.drawing, mm) - margin_mm;
      if (distance <= 0) cut.At(col, row) = seen.At(col, row);
    }
  }
  return cut;
}

// The scan is held fast and the drawing moves under it. The other way round the scan would be
// interpolated, which smooths its grain most at half pixels and so pulls the match there.
std::optional<MarkPosition> MatchDrawing(const Image& seen, const MarkShape& shape,
                                         const Matrix2d& pixel_from_mm, const Vector2d& from,
                                         double blur_px, double max_shift_px) {
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  RenderOptions render;
  const double margin_mm = render.margin_mm + kGradientPx / pixels_per_mm;
  render.blur_sigma_px = blur_px;
  render.background_sigma_px = kBackgroundSigmaMm * pixels_per_mm;
  render.margin_mm = margin_mm + (max_shift_px + kGradientPx + 2) / pixels_per_mm;
  const MarkTemplate drawn = RenderMark(shape, pixel_from_mm, render);
  const Image cut = CutOut(seen, shape, pixel_from_mm.inverse(), from, margin_mm);
  LsmOptions lsm;
  lsm.geometry = LsmGeometry::kShift;  // size and turn come from all marks together
  lsm.max_shift_px = max_shift_px;
  const Affine2d start{Matrix2d::Identity(), drawn.centre - from};
  const auto match = MatchLeastSquares(cut, drawn.values, from, start, lsm);
  if (!match || match->gain <= 0 || match->correlation <= 0) return std::nullopt;
  MarkPosition result;
  result.pixel = from - (match->position - drawn.centre);
  const auto covariance = ShiftCovariance(cut, drawn.values, match->position - from);
  if (!covariance) return std::nullopt;
  result.covariance = *covariance;
  result.correlation = match->correlation;
  result.blur_sigma_px = blur_px;
  return result;
}

}  // namespace

std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Matrix2d& pixel_from_mm, const Vector2d& start,
                                        Polarity polarity, double max_shift_px) {
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double background_px = kBackgroundSigmaMm * pixels_per_mm;
  const double reach = (MarkRadius(shape) + 2 * kBackgroundSigmaMm) * pixels_per_mm + max_shift_px;
  ImageWindow seen = ReadAround(scan, start, reach + kGradientPx);
  MakePositive(&seen.image, polarity);
  seen.image = RemoveBackground(seen.image, background_px);
  std::optional<MarkPosition> best;
  Vector2d from = seen.ImageFromRaster(start);
  for (const double blur : kBlurs) {
    const auto match = MatchDrawing(seen.image, shape, pixel_from_mm, from, blur, max_shift_px);
    if (!match || (seen.RasterFromImage(match->pixel) - start).norm() > max_shift_px) continue;
    from = match->pixel;
    if (!best || match->correlation > best->correlation) best = match;
  }
  if (best) best->pixel = seen.RasterFromImage(best->pixel);
  return best;
}

}  // namespace orient
