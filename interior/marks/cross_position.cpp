#include "interior/marks/cross_position.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "interior/marks/background.h"
#include "interior/marks/stroke_fit.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Smoothing of the profiles, besides the stroke's own width; and a second one: the change that it
// makes shows the influence of the picture around the stroke.
constexpr double kSmoothingPx = 1.2, kOtherSmoothingPx = 1.6;
constexpr double kShareOfDifference = 0.3;  // of its square, in the variance

// `dark`: the strokes are dark, and the window is inverted.
ImageWindow ReadFlat(const Raster& scan, const Vector2d& centre, double reach_px,
                     double background_px, bool dark) {
  const int half = static_cast<int>(std::ceil(reach_px));
  const int col = static_cast<int>(std::floor(centre.x()));
  const int row = static_cast<int>(std::floor(centre.y()));
  ImageWindow seen = scan.ReadGrey({col - half, row - half, 2 * half + 1, 2 * half + 1});
  if (dark)
    for (float& value : seen.image.values) value = -value;
  seen.image = RemoveBackground(seen.image, background_px);
  return seen;
}

// The two strokes' crossing, from the mark's predicted centre at `middle`.
std::optional<MeasuredCross> Crossing(const Image& image, const CrossElement& cross,
                                      const Matrix2d& pixel_from_mm, const Vector2d& middle,
                                      double max_shift_px, double blur_px) {
  const Vector2d centre = middle + pixel_from_mm * cross.at_mm;
  std::optional<StrokeFit> level, steep;
  const Plane plane(image, false), transposed(image, true);
  for (const double turn : {0.0, std::numbers::pi / 2}) {
    const Stroke stroke = StrokeOf(cross, cross.angle_rad + turn, pixel_from_mm, blur_px);
    auto& fit = stroke.steep ? steep : level;
    fit.emplace(stroke.steep ? transposed : plane,
                stroke.steep ? Vector2d(centre.y(), centre.x()) : centre, stroke);
    if (!fit->Fit(max_shift_px)) return std::nullopt;
  }
  if (!level || !steep) return std::nullopt;
  // y = a + b x and x = c + d y.
  const Stroke &across = level->Line(), &down = steep->Line();
  const Matrix2d lines = (Matrix2d() << -across.slope, 1, 1, -down.slope).finished();
  if (std::abs(lines.determinant()) < 0.1) return std::nullopt;
  const Matrix2d inverse = lines.inverse();
  const Vector2d shift = inverse * Vector2d(across.offset, down.offset);
  if (!(shift.norm() <= max_shift_px)) return std::nullopt;
  const Vector2d variances(level->VarianceAt(shift.x()), steep->VarianceAt(shift.y()));
  if (!(variances.minCoeff() > 0)) return std::nullopt;
  MeasuredCross position;
  position.pixel = middle + shift;
  const StrokeEvidence on_level = level->Evidence(), on_steep = steep->Evidence();
  position.share = std::min(on_level.share, on_steep.share);
  position.nats = std::min(on_level.nats, on_steep.nats);
  position.covariance = inverse * variances.asDiagonal() * inverse.transpose();
  return position;
}

}  // namespace

std::optional<MeasuredCross> MeasureCross(const Raster& scan, const CrossElement& cross,
                                          const Matrix2d& pixel_from_mm, const Vector2d& start,
                                          Polarity polarity, double max_shift_px) {
  const double pixel_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double background_px = kBackgroundSigmaMm * pixel_per_mm;
  const double reach_px = 0.55 * cross.length_mm * pixel_per_mm + max_shift_px + background_px;
  const Vector2d cross_at = start + pixel_from_mm * cross.at_mm;
  const bool dark = (polarity == Polarity::kNegative) != (cross.brightness <= 0);
  const ImageWindow seen = ReadFlat(scan, cross_at, reach_px, background_px, dark);
  const auto measure = [&](const Vector2d& from, double blur_px) {
    return Crossing(seen.image, cross, pixel_from_mm, seen.ImageFromRaster(from), max_shift_px,
                    blur_px);
  };
  std::optional<MeasuredCross> position = measure(start, kSmoothingPx);
  if (!position) return std::nullopt;
  const auto other = measure(start, kOtherSmoothingPx);
  if (!other) return std::nullopt;
  const Vector2d difference = other->pixel - position->pixel;
  position->covariance += kShareOfDifference * difference.cwiseAbs2().asDiagonal().toDenseMatrix();
  position->pixel = seen.RasterFromImage(position->pixel);
  return position;
}

}  // namespace orient::interior
