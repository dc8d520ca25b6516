#include "core/geometry/film_correction.h"

#include <Eigen/LU>
#include <algorithm>
#include <stdexcept>

namespace orient {

Eigen::Vector2d FilmCorrection::At(const Eigen::Vector2d& pixel) const {
  if (columns < 2 || rows < 2 ||
      correction_mm.size() != static_cast<size_t>(columns) * static_cast<size_t>(rows))
    throw std::invalid_argument("FilmCorrection: the values do not fill columns x rows");
  const Eigen::Vector2d node = (pixel - origin_px).cwiseQuotient(step_px);
  const double u = std::clamp(node.x(), 0.0, columns - 1.0);
  const double v = std::clamp(node.y(), 0.0, rows - 1.0);
  const int col = std::min(static_cast<int>(u), columns - 2);
  const int row = std::min(static_cast<int>(v), rows - 2);
  const double right = u - col, down = v - row;
  const Eigen::Vector2d* upper = &correction_mm[static_cast<size_t>(row) * columns + col];
  const Eigen::Vector2d* lower = upper + columns;
  return (1 - down) * ((1 - right) * upper[0] + right * upper[1]) +
         down * ((1 - right) * lower[0] + right * lower[1]);
}

Eigen::Vector2d PhotoFromPixel(const Affine2d& photo_from_pixel, const FilmCorrection* correction,
                               const Eigen::Vector2d& pixel) {
  Eigen::Vector2d photo_mm = photo_from_pixel * pixel;
  if (correction != nullptr) photo_mm += correction->At(pixel);
  return photo_mm;
}

Eigen::Vector2d PixelFromPhoto(const Affine2d& photo_from_pixel, const FilmCorrection* correction,
                               const Eigen::Vector2d& photo_mm) {
  const Affine2d pixel_from_photo = photo_from_pixel.Inverse();
  Eigen::Vector2d pixel = pixel_from_photo * photo_mm;
  if (correction == nullptr) return pixel;
  // The correction's slope is of the order of 1e-3, so each round gains three digits.
  constexpr int kRounds = 4;
  for (int i = 0; i < kRounds; ++i) pixel = pixel_from_photo * (photo_mm - correction->At(pixel));
  return pixel;
}

}  // namespace orient
