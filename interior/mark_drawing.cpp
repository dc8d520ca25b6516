#include "interior/mark_drawing.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/imaging/correlation.h"
#include "core/imaging/resample.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// Unsigned distance to the nearest outline of any element, painted over or not.
double OutlineDistance(const MarkDrawing& drawing, const Vector2d& point_mm) {
  double distance = std::numeric_limits<double>::infinity();
  for (const MarkElement& e : drawing.elements)
    distance = std::min(distance, std::abs(SignedDistance(e, point_mm)));
  return distance;
}

// Brightness of the mark at a point, mark system; NaN outside a picture.
float BrightnessAt(const MarkShape& shape, const Vector2d& point_mm) {
  if (!shape.picture)
    return static_cast<float>(PaintedBrightness(shape.drawing.elements, point_mm));
  const MarkImage& source = *shape.drawing.image;
  const Vector2d offset(point_mm.x() / source.pixel_size_mm, -point_mm.y() / source.pixel_size_mm);
  return SampleBilinear(*shape.picture, source.centre_px + offset);
}

float MeanOverPixel(const MarkShape& shape, const Matrix2d& mm_from_pixel, const Vector2d& corner,
                    int supersampling) {
  if (!shape.picture) {  // no outline passes through most pixels
    const double half_diagonal = 0.5 * (mm_from_pixel.col(0).norm() + mm_from_pixel.col(1).norm());
    const Vector2d centre = mm_from_pixel * (corner + Vector2d(0.5, 0.5));
    if (OutlineDistance(shape.drawing, centre) > half_diagonal) return BrightnessAt(shape, centre);
  }
  double sum = 0;
  for (int j = 0; j < supersampling; ++j) {
    for (int i = 0; i < supersampling; ++i) {
      const Vector2d sub((i + 0.5) / supersampling, (j + 0.5) / supersampling);
      sum += static_cast<double>(BrightnessAt(shape, mm_from_pixel * (corner + sub)));
    }
  }
  return static_cast<float>(sum / (supersampling * supersampling));
}

void CheckShape(const MarkShape& shape, const Matrix2d& pixel_from_mm) {
  if (std::abs(pixel_from_mm.determinant()) < 1e-12)
    throw std::invalid_argument("RenderMark: pixel_from_mm is singular");
  if (shape.drawing.image && !shape.picture)
    throw std::invalid_argument("RenderMark: the mark's picture was not handed in");
  if (!shape.picture && shape.drawing.elements.empty())
    throw std::invalid_argument("RenderMark: the drawing has no elements");
}

}  // namespace

double MarkRadius(const MarkShape& shape) {
  double radius = 0;
  for (const MarkElement& e : shape.drawing.elements) radius = std::max(radius, Reach(e));
  if (shape.picture)
    radius = 0.5 * shape.drawing.image->pixel_size_mm *
             std::min(shape.picture->width, shape.picture->height);
  return radius;
}

double ThinnestStroke(const MarkShape& shape) {
  if (shape.picture || shape.drawing.elements.empty()) return 0.1;
  double stroke = std::numeric_limits<double>::infinity();
  for (const MarkElement& e : shape.drawing.elements) stroke = std::min(stroke, Thickness(e));
  return stroke;
}

double StrokeDistance(const MarkDrawing& drawing, const Vector2d& point_mm) {
  double distance = std::numeric_limits<double>::infinity();
  for (const MarkElement& element : drawing.elements)
    distance = std::min(distance, SignedDistance(element, point_mm));
  return distance;
}

MarkTemplate RenderMark(const MarkShape& shape, const Matrix2d& pixel_from_mm,
                        const RenderOptions& options) {
  CheckShape(shape, pixel_from_mm);
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const double reach_mm = MarkRadius(shape) + (shape.picture ? 0.0 : options.margin_mm);
  const int half = static_cast<int>(std::ceil(reach_mm * pixels_per_mm * 1.03 + 0.5));
  const int pad =
      static_cast<int>(std::ceil(3 * std::max(options.blur_sigma_px, options.background_sigma_px)));
  const int size = 2 * (half + pad) + 1;
  const Vector2d centre = Vector2d::Constant(half + pad + 0.5);
  Image full(size, size);
  for (int row = 0; row < size; ++row)
    for (int col = 0; col < size; ++col)
      full.At(col, row) =
          MeanOverPixel(shape, mm_from_pixel, Vector2d(col, row) - centre, options.supersampling);
  if (options.blur_sigma_px > 0) full = GaussianBlur(full, options.blur_sigma_px);
  if (options.background_sigma_px > 0) full = RemoveBackground(full, options.background_sigma_px);

  MarkTemplate result;
  result.values = Image(2 * half + 1, 2 * half + 1, kNoData);
  result.centre = Vector2d::Constant(half + 0.5);
  for (int row = 0; row < result.values.height; ++row) {
    for (int col = 0; col < result.values.width; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - result.centre);
      if (shape.picture || StrokeDistance(shape.drawing, mm) <= options.margin_mm)
        result.values.At(col, row) = full.At(col + pad, row + pad);
    }
  }
  return result;
}

bool LooksSame(const MarkShape& shape, const Matrix2d& turn) {
  return LooksSame(shape, shape, turn);
}

bool LooksSame(const MarkShape& shape, const MarkShape& turned, const Matrix2d& turn) {
  // 24 px over the mark show every element; a margin beyond the radius keeps the same pixels valid.
  const double radius = std::max(MarkRadius(shape), MarkRadius(turned));
  const Matrix2d upright = Eigen::DiagonalMatrix<double, 2>(1, -1) * (12.0 / radius);
  const auto render = [&](const MarkShape& s, const Matrix2d& pixel_from_mm) {
    return RenderMark(s, pixel_from_mm, {0.7, 3 * radius - MarkRadius(s), 4});
  };
  const MarkTemplate a = render(shape, upright);
  const MarkTemplate b = render(turned, upright * turn.transpose());
  if (a.values.width != b.values.width) return false;  // pictures of different sizes
  constexpr double kSame = 0.9;
  return CorrelationCoefficient(a.values, b.values, 0.5) > kSame;
}

}  // namespace orient
