#include "interior/subpixel.h"

#include <Eigen/LU>

#include "core/imaging/resample.h"
#include "interior/match_precision.h"
#include "interior/moving_drawing.h"

namespace orient {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;

// From the widest to the sharpest: the wide one pulls in from afar, each starts where the last one
// ended.
constexpr std::array<double, 6> kBlurs = {2.6, 1.8, 1.3, 0.95, 0.7, 0.5};

// Near enough to tell which blur fits best, in parts of the blur: the correlation hardly changes.
constexpr double kNear = 0.04;

// Pixels beyond the drawing's margin that take part, and those that blur and spline need besides.
constexpr double kMarginPx = 3;
constexpr int kSupportPx = 12;

double PixelsPerMm(const Matrix2d& pixel_from_mm) {
  return std::sqrt(std::abs(pixel_from_mm.determinant()));
}

// With zeros around it, as beyond its strokes a drawing is; a picture just ends.
Image Padded(const Image& image, int by, float fill) {
  Image padded(image.width + 2 * by, image.height + 2 * by, fill);
  for (int row = 0; row < image.height; ++row)
    for (int col = 0; col < image.width; ++col)
      padded.At(col + by, row + by) = std::isfinite(image.At(col, row)) ? image.At(col, row) : fill;
  return padded;
}

// Of a drawing without NaN that is flat at its border.
FloatPlane Blurred(const FloatPlane& plane, double sigma) {
  const auto reach = static_cast<Index>(std::ceil(4 * sigma));
  Eigen::ArrayXf weights(2 * reach + 1);
  for (Index i = -reach; i <= reach; ++i)
    weights[i + reach] =
        static_cast<float>(std::exp(-0.5 * static_cast<double>(i * i) / (sigma * sigma)));
  return SeparableSums(plane, weights / weights.sum());
}

Image AsImage(const FloatPlane& plane) {
  Image image(static_cast<int>(plane.cols()), static_cast<int>(plane.rows()));
  std::copy_n(plane.data(), plane.size(), image.values.data());
  return image;
}

ImageWindow ReadAround(const Raster& scan, const Vector2d& centre, int half) {
  const int col = static_cast<int>(std::floor(centre.x()));
  const int row = static_cast<int>(std::floor(centre.y()));
  return scan.ReadGrey({col - half, row - half, 2 * half + 1, 2 * half + 1});
}

// Bright strokes are what the drawing shows.
void MakePositive(Image* image, Polarity polarity) {
  if (polarity == Polarity::kPositive) return;
  for (float& value : image->values) value = -value;
}

}  // namespace

struct MarkMeasurer::Drawn {
  struct Level {
    double blur_px;
    Image values;
    MovingDrawing moving;
  };

  Drawn(const MarkShape& shape, const Matrix2d& pixel_from_mm);

  // The scan where the drawing's pixels take part, its centre at `centre`; no larger than they
  // need.
  ImageWindow CutOut(const Image& seen, const Vector2d& centre) const;

  double background_px = 0;
  FloatPlane part;  // pixels that take part
  int border = 0;   // so many outermost rows and columns take no part
  std::vector<Level> levels;
};

MarkMeasurer::Drawn::Drawn(const MarkShape& shape, const Matrix2d& pixel_from_mm) {
  const double pixels_per_mm = PixelsPerMm(pixel_from_mm);
  background_px = kBackgroundSigmaMm * pixels_per_mm;
  RenderOptions render;
  render.blur_sigma_px = 0;
  const double margin_mm = render.margin_mm + kMarginPx / pixels_per_mm;
  render.margin_mm = margin_mm + kSupportPx / pixels_per_mm;
  const MarkTemplate sharp = RenderMark(shape, pixel_from_mm, render);
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  const int side = sharp.values.width;
  std::vector<bool> near;
  if (!shape.picture) near = NearStrokes(shape.drawing, mm_from_pixel, side / 2, margin_mm);
  part = FloatPlane::Zero(side, side);
  double sum = 0, count = 0;
  for (int row = 0; row < side; ++row) {
    for (int col = 0; col < side; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - sharp.centre);
      const bool used = shape.picture ? mm.norm() <= MarkRadius(shape)
                                      : near[static_cast<size_t>(row * side + col)];
      if (!used || !std::isfinite(sharp.values.At(col, row))) continue;
      part(row, col) = 1;
      sum += static_cast<double>(sharp.values.At(col, row));
      ++count;
    }
  }
  const auto takes_part = [&](int edge) {
    return (part.row(edge) > 0).any() || (part.row(side - 1 - edge) > 0).any() ||
           (part.col(edge) > 0).any() || (part.col(side - 1 - edge) > 0).any();
  };
  while (border < side / 2 && !takes_part(border)) ++border;
  const int pad = static_cast<int>(std::ceil(2 * background_px));
  const auto fill = static_cast<float>(shape.picture ? sum / std::max(count, 1.0) : 0.0);
  const Image flat = RemoveBackground(Padded(sharp.values, pad, fill), background_px);
  FloatPlane plane(sharp.values.height, sharp.values.width);
  for (int row = 0; row < sharp.values.height; ++row)
    for (int col = 0; col < sharp.values.width; ++col)
      plane(row, col) = flat.At(col + pad, row + pad);
  for (const double blur : kBlurs) {
    const FloatPlane blurred = Blurred(plane, blur);
    levels.push_back({blur, AsImage(blurred), MovingDrawing(blurred, part)});
  }
}

ImageWindow MarkMeasurer::Drawn::CutOut(const Image& seen, const Vector2d& centre) const {
  const auto side = static_cast<int>(part.rows()), inner = side - 2 * border;
  ImageWindow cut{Image(inner, inner, kNoData), (centre.array() - 0.5 * side).round() + border, 1};
  const int left = static_cast<int>(cut.origin.x()), top = static_cast<int>(cut.origin.y());
  for (int row = std::max(0, -top); row < std::min(inner, seen.height - top); ++row)
    for (int col = std::max(0, -left); col < std::min(inner, seen.width - left); ++col)
      if (part(row + border, col + border) > 0)
        cut.image.At(col, row) = seen.At(col + left, row + top);
  return cut;
}

MarkMeasurer::MarkMeasurer(const MarkShape& shape, const Matrix2d& pixel_from_mm)
    : drawn_(std::make_unique<Drawn>(shape, pixel_from_mm)) {}
MarkMeasurer::~MarkMeasurer() = default;
MarkMeasurer::MarkMeasurer(MarkMeasurer&&) noexcept = default;
MarkMeasurer& MarkMeasurer::operator=(MarkMeasurer&&) noexcept = default;

std::optional<MarkPosition> MarkMeasurer::Measure(const Raster& scan, const Vector2d& start,
                                                  Polarity polarity, double max_shift_px) const {
  const double half = 0.5 * static_cast<double>(drawn_->part.rows());
  const double reach = half + std::max(max_shift_px + 1, drawn_->background_px);
  ImageWindow seen = ReadAround(scan, start, static_cast<int>(std::ceil(reach)));
  MakePositive(&seen.image, polarity);
  seen.image = RemoveBackground(seen.image, drawn_->background_px);
  const SeenPlane plane(seen.image);
  const Vector2d first = seen.ImageFromRaster(start);
  Vector2d from = first;
  std::optional<DrawingMatch> best;
  const Drawn::Level* sharpness = nullptr;
  for (const Drawn::Level& level : drawn_->levels) {
    const auto match = level.moving.Match(plane, from, max_shift_px, kNear * level.blur_px);
    if (!match || match->correlation <= 0 || (match->centre - first).norm() > max_shift_px)
      continue;
    from = match->centre;
    if (best && best->correlation >= match->correlation) continue;
    best = match;
    sharpness = &level;
  }
  if (best) best = sharpness->moving.Match(plane, best->centre, max_shift_px);
  if (!best || best->correlation <= 0 || (best->centre - first).norm() > max_shift_px)
    return std::nullopt;
  const Vector2d drawing_centre = Vector2d::Constant(half);
  const ImageWindow cut = drawn_->CutOut(seen.image, best->centre);
  const auto covariance =
      ShiftCovariance(cut.image, sharpness->values, drawing_centre - best->centre + cut.origin);
  if (!covariance) return std::nullopt;
  return MarkPosition{seen.RasterFromImage(best->centre), *covariance, best->correlation,
                      sharpness->blur_px};
}

std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Matrix2d& pixel_from_mm, const Vector2d& start,
                                        Polarity polarity, double max_shift_px) {
  return MarkMeasurer(shape, pixel_from_mm).Measure(scan, start, polarity, max_shift_px);
}

}  // namespace orient
