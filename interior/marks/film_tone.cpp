#include "interior/marks/film_tone.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "core/raster/resample.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kMinPixels = 20;

PixelWindow WindowAround(const Vector2d& low, const Vector2d& high) {
  const Vector2d from = low.array().floor() - 2, to = high.array().ceil() + 2;
  return {static_cast<int>(from.x()), static_cast<int>(from.y()),
          static_cast<int>(to.x() - from.x()), static_cast<int>(to.y() - from.y())};
}

double PixelsPerMm(const Matrix2d& pixel_from_mm) {
  return std::sqrt(std::abs(pixel_from_mm.determinant()));
}

}  // namespace

std::optional<FilmTone> ToneAtMark(const Raster& scan, const MarkShape& shape,
                                   const Matrix2d& pixel_from_mm, const Vector2d& pixel,
                                   Polarity polarity) {
  const MarkTemplate drawn = RenderMark(shape, pixel_from_mm);
  const Vector2d corner = pixel - drawn.centre;
  const Vector2d size(drawn.values.width, drawn.values.height);
  const ImageWindow seen = scan.ReadGrey(WindowAround(corner, corner + size));
  double n = 0, sum_t = 0, sum_g = 0, sum_tt = 0, sum_tg = 0;
  for (int row = 0; row < drawn.values.height; ++row) {
    for (int col = 0; col < drawn.values.width; ++col) {
      const double t = drawn.values.At(col, row);
      const double g =
          SampleBilinear(seen.image, seen.ImageFromRaster(corner + Vector2d(col + 0.5, row + 0.5)));
      if (std::isnan(t) || std::isnan(g)) continue;
      n += 1;
      sum_t += t;
      sum_g += g;
      sum_tt += t * t;
      sum_tg += t * g;
    }
  }
  const double spread = n * sum_tt - sum_t * sum_t;
  if (n < kMinPixels || spread <= 0) return std::nullopt;
  const double contrast = (n * sum_tg - sum_t * sum_g) / spread;
  if (polarity == Polarity::kPositive ? contrast <= 0 : contrast >= 0) return std::nullopt;
  const double surrounding = (sum_g - contrast * sum_t) / n;
  return FilmTone{surrounding, surrounding + contrast};
}

float TonePicture::At(const Vector2d& photo_mm) const {
  return SampleBilinear(tone, (photo_mm - low_mm) / step_mm);
}

TonePicture ReadTones(const Raster& scan, const Affine2d& pixel_from_photo, const FilmTone& tone,
                      const Vector2d& low_mm, const Vector2d& high_mm, double step_mm) {
  Eigen::AlignedBox2d box;
  for (const double x : {low_mm.x(), high_mm.x()})
    for (const double y : {low_mm.y(), high_mm.y()}) box.extend(pixel_from_photo * Vector2d(x, y));
  const double reduction = std::max(1.0, step_mm * PixelsPerMm(pixel_from_photo.A));
  const ImageWindow seen = scan.ReadGrey(WindowAround(box.min(), box.max()), reduction);
  const Vector2d cells = ((high_mm - low_mm) / step_mm).array().round().max(1.0);
  TonePicture picture{Image(static_cast<int>(cells.x()), static_cast<int>(cells.y())), low_mm,
                      step_mm};
  for (int j = 0; j < picture.tone.height; ++j) {
    for (int i = 0; i < picture.tone.width; ++i) {
      const Vector2d at = low_mm + step_mm * Vector2d(i + 0.5, j + 0.5);
      const double grey = SampleBilinear(seen.image, seen.ImageFromRaster(pixel_from_photo * at));
      picture.tone.At(i, j) = static_cast<float>(tone.Of(grey));
    }
  }
  return picture;
}

}  // namespace orient::interior
