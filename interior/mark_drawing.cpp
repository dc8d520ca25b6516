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

// The share of an element in what is seen around a point whose signed distance from its outline,
// over the sample's side, is `distance`: a straight outline under a triangle two sides wide.
double SmoothShare(double distance) {
  if (distance >= 1) return 0;
  if (distance <= -1) return 1;
  const double beyond = 1 - std::abs(distance);
  return distance > 0 ? 0.5 * beyond * beyond : 1 - 0.5 * beyond * beyond;
}

// As painted, each outline as smooth as samples `side_mm` apart need.
double SmoothBrightness(const std::vector<MarkElement>& elements, const Vector2d& point_mm,
                        double side_mm) {
  double brightness = 0;
  for (const MarkElement& e : elements)
    brightness +=
        SmoothShare(SignedDistance(e, point_mm) / side_mm) * (BrightnessOf(e) - brightness);
  return brightness;
}

// An outline stays at least this far from everything that a pixel's samples see.
double HalfDiagonal(const Matrix2d& mm_from_pixel, const RenderOptions& options) {
  const double corners = 0.5 * (mm_from_pixel.col(0).norm() + mm_from_pixel.col(1).norm());
  return options.smooth_outlines ? corners * (1 + 1.0 / options.supersampling) : corners;
}

float MeanOverPixel(const MarkShape& shape, const Matrix2d& mm_from_pixel, const Vector2d& corner,
                    const RenderOptions& options) {
  const int per_axis = options.supersampling;
  const bool smooth = options.smooth_outlines && !shape.picture;
  const double side_mm = std::sqrt(std::abs(mm_from_pixel.determinant())) / per_axis;
  double sum = 0;
  for (int j = 0; j < per_axis; ++j) {
    for (int i = 0; i < per_axis; ++i) {
      const Vector2d sub((i + 0.5) / per_axis, (j + 0.5) / per_axis);
      const Vector2d mm = mm_from_pixel * (corner + sub);
      sum += smooth ? SmoothBrightness(shape.drawing.elements, mm, side_mm)
                    : static_cast<double>(BrightnessAt(shape, mm));
    }
  }
  return static_cast<float>(sum / (per_axis * per_axis));
}

// Means over the pixels of an image with the mark's centre at `centre`. No outline passes through
// most pixels, and where the nearest one is far off, none through the next ones of the row either.
Image MeansOverPixels(const MarkShape& shape, const Matrix2d& mm_from_pixel, int size,
                      const Vector2d& centre, const RenderOptions& options) {
  const double half_diagonal = HalfDiagonal(mm_from_pixel, options);
  const double step_mm = mm_from_pixel.col(0).norm();
  Image image(size, size);
  for (int row = 0; row < size; ++row) {
    for (int col = 0; col < size;) {
      const Vector2d corner = Vector2d(col, row) - centre;
      const Vector2d middle = mm_from_pixel * (corner + Vector2d(0.5, 0.5));
      const double free =
          shape.picture ? 0 : OutlineDistance(shape.drawing, middle) - half_diagonal;
      if (free <= 0) {
        image.At(col++, row) = MeanOverPixel(shape, mm_from_pixel, corner, options);
        continue;
      }
      const int stop =
          static_cast<int>(std::min<double>(size, col + 1 + std::floor(free / step_mm)));
      std::fill(image.Row(row) + col, image.Row(row) + stop, BrightnessAt(shape, middle));
      col = stop;
    }
  }
  return image;
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
  const Vector2d centre = Vector2d::Constant(half + pad + 0.5) + options.offset_px;
  Image full = MeansOverPixels(shape, mm_from_pixel, size, centre, options);
  if (options.blur_sigma_px > 0) full = GaussianBlur(full, options.blur_sigma_px);
  if (options.background_sigma_px > 0) full = RemoveBackground(full, options.background_sigma_px);

  MarkTemplate result;
  result.values = Image(2 * half + 1, 2 * half + 1, kNoData);
  result.centre = Vector2d::Constant(half + 0.5) + options.offset_px;
  const std::vector<bool> part =
      shape.picture ? std::vector<bool>(result.values.values.size(), true)
                    : NearStrokes(shape.drawing, mm_from_pixel, half, options.margin_mm);
  for (int row = 0; row < result.values.height; ++row)
    for (int col = 0; col < result.values.width; ++col)
      if (part[static_cast<size_t>(row * result.values.width + col)])
        result.values.At(col, row) = full.At(col + pad, row + pad);
  return result;
}

std::vector<bool> NearStrokes(const MarkDrawing& drawing, const Matrix2d& mm_from_pixel, int half,
                              double margin_mm) {
  const int side = 2 * half + 1;
  const double step_mm = mm_from_pixel.col(0).norm();
  std::vector<bool> near(static_cast<size_t>(side * side));
  for (int row = 0; row < side; ++row) {
    for (int col = 0; col < side;) {
      const double beyond_mm =
          StrokeDistance(drawing, mm_from_pixel * Vector2d(col - half, row - half)) - margin_mm;
      // The distance changes by no more than a step from pixel to pixel.
      const double alike = 1 + std::floor(std::abs(beyond_mm) / step_mm * (1 - 1e-9));
      const int stop = static_cast<int>(std::min<double>(side, col + alike));
      for (; col < stop; ++col) near[static_cast<size_t>(row * side + col)] = beyond_mm <= 0;
    }
  }
  return near;
}

namespace {

// 24 px over the mark show every element; a margin beyond the radius keeps the same pixels valid.
MarkTemplate SmallPicture(const MarkShape& shape, double radius_mm, const Matrix2d& turn) {
  const Matrix2d upright = Eigen::DiagonalMatrix<double, 2>(1, -1) * (12.0 / radius_mm);
  return RenderMark(shape, upright * turn.transpose(), {0.7, 3 * radius_mm - MarkRadius(shape), 4});
}

bool AreAlike(const MarkTemplate& a, const MarkTemplate& b) {
  if (a.values.width != b.values.width) return false;  // pictures of different sizes
  constexpr double kSame = 0.9;
  return CorrelationCoefficient(a.values, b.values, 0.5) > kSame;
}

}  // namespace

bool LooksSame(const MarkShape& shape, const Matrix2d& turn) {
  return LooksSame(shape, shape, turn);
}

bool LooksSame(const MarkShape& shape, const MarkShape& turned, const Matrix2d& turn) {
  const double radius = std::max(MarkRadius(shape), MarkRadius(turned));
  return AreAlike(SmallPicture(shape, radius, Matrix2d::Identity()),
                  SmallPicture(turned, radius, turn));
}

bool MarkLikeness::Same(const std::string& mark, const std::string& turned, const Matrix2d& turn) {
  const Key key{mark, turned, {turn(0, 0), turn(0, 1), turn(1, 0), turn(1, 1)}};
  const auto known = known_.find(key);
  if (known != known_.end()) return known->second;
  const MarkShape &shape = shapes_.at(mark), &other = shapes_.at(turned);
  const double radius = std::max(MarkRadius(shape), MarkRadius(other));
  auto upright = upright_.find({mark, radius});
  if (upright == upright_.end())
    upright =
        upright_.try_emplace({mark, radius}, SmallPicture(shape, radius, Matrix2d::Identity()))
            .first;
  const bool same = AreAlike(upright->second, SmallPicture(other, radius, turn));
  known_.emplace(key, same);
  return same;
}

}  // namespace orient
