#include "interior/marks/matching_drawing.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace orient::interior {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kRoughBlurs[] = {2.6, 1.5, 0.95, 0.6};
constexpr double kSharpest = 0.3, kStep = 1.02;

// A scanner's optics blur before its pixels average; in the other order strokes of two pixels are
// aliased (by 0.005 px). kFiner finer pixels per axis are blurred, each of kSamples samples.
constexpr int kFiner = 2, kSamples = 2;

// Pixels beyond the drawing's margin that take part, and those that blur and spline need besides.
constexpr double kMarginPx = 3;
constexpr int kSupportPx = 12;

double PixelsPerMm(const Matrix2d& pixel_from_mm) {
  return std::sqrt(std::abs(pixel_from_mm.determinant()));
}

FloatPlane AsPlane(const Image& image) {
  return Eigen::Map<const FloatPlane>(image.values.data(), image.height, image.width);
}

Image AsImage(const FloatPlane& plane) {
  Image image(static_cast<int>(plane.cols()), static_cast<int>(plane.rows()));
  std::copy_n(plane.data(), plane.size(), image.values.data());
  return image;
}

// With `fill` around it, the value of a drawing beyond its strokes; a picture has none there.
FloatPlane Padded(const FloatPlane& plane, Index by, float fill) {
  FloatPlane padded = FloatPlane::Constant(plane.rows() + 2 * by, plane.cols() + 2 * by, fill);
  padded.block(by, by, plane.rows(), plane.cols()) = plane.isFinite().select(plane, fill);
  return padded;
}

// The drawing in pixels of half the size, an odd number of whole pixels on a side with its centre
// in the middle; NaN beyond a picture.
FloatPlane DrawFinely(const MarkShape& shape, const Matrix2d& pixel_from_mm, double margin_mm) {
  RenderOptions render;
  render.blur_sigma_px = 0;
  render.margin_mm = margin_mm + kSupportPx / PixelsPerMm(pixel_from_mm);
  render.offset_px = Vector2d::Constant(-0.5);  // an odd side's middle is a corner of finer pixels
  render.supersampling = kSamples;
  render.smooth_outlines = true;
  render.whole_square = true;
  const Image drawn = RenderMark(shape, kFiner * pixel_from_mm, render).values;
  const int middle = drawn.width / 2;  // before the first pixel right of the centre
  const int half = (middle - 1) / kFiner * kFiner + 1, side = 2 * half;
  return AsPlane(drawn).block(middle - half, middle - half, side, side);
}

FloatPlane InWholePixels(const FloatPlane& fine) {
  const Index side = fine.rows() / kFiner;
  const auto every = [&](Index from) { return Eigen::seqN(from, side, kFiner); };
  return 0.25f * (fine(every(0), every(0)) + fine(every(0), every(1)) + fine(every(1), every(0)) +
                  fine(every(1), every(1)));
}

// Linearly between whole pixels; constant beyond.
FloatPlane InFinePixels(const FloatPlane& plane) {
  const auto between_rows = [](const FloatPlane& p) {
    FloatPlane fine(kFiner * p.rows(), p.cols());
    for (Index row = 0; row < p.rows(); ++row) {
      const Index above = std::max<Index>(row - 1, 0), below = std::min(row + 1, p.rows() - 1);
      fine.row(kFiner * row) = 0.75f * p.row(row) + 0.25f * p.row(above);
      fine.row(kFiner * row + 1) = 0.75f * p.row(row) + 0.25f * p.row(below);
    }
    return fine;
  };
  return between_rows(between_rows(plane).transpose()).transpose();
}

// Mean of the pixel's neighbours that have a value; there must be some.
float MeanAround(const FloatPlane& plane, Index row, Index col) {
  float sum = 0, count = 0;
  for (Index r = std::max<Index>(row - 1, 0); r <= std::min(row + 1, plane.rows() - 1); ++r)
    for (Index c = std::max<Index>(col - 1, 0); c <= std::min(col + 1, plane.cols() - 1); ++c) {
      if (!std::isfinite(plane(r, c))) continue;
      sum += plane(r, c);
      ++count;
    }
  return sum / count;
}

// Fills pixels without a value from their neighbours, up to `steps` pixels far, and zero beyond.
FloatPlane Extended(FloatPlane plane, int steps) {
  using Places = std::vector<std::pair<Index, Index>>;
  const Index rows = plane.rows(), cols = plane.cols();
  Eigen::Array<bool, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> known = plane.isFinite();
  // Pixels without a value beside these; they count as known from now on.
  const auto beside = [&](const Places& places) {
    Places next;
    for (const auto& [row, col] : places)
      for (Index r = std::max<Index>(row - 1, 0); r <= std::min(row + 1, rows - 1); ++r)
        for (Index c = std::max<Index>(col - 1, 0); c <= std::min(col + 1, cols - 1); ++c)
          if (!std::exchange(known(r, c), true)) next.emplace_back(r, c);
    return next;
  };
  Places edge;
  for (Index r = 0; r < rows; ++r)
    for (Index c = 0; c < cols; ++c)
      if (known(r, c)) edge.emplace_back(r, c);
  std::vector<float> means;
  for (int step = 0; step < steps; ++step) {
    edge = beside(edge);
    means.clear();
    for (const auto& [row, col] : edge) means.push_back(MeanAround(plane, row, col));
    for (size_t i = 0; i < edge.size(); ++i) plane(edge[i].first, edge[i].second) = means[i];
  }
  return plane.isFinite().select(plane, 0.0f);
}

int EmptyBorder(const FloatPlane& part) {
  const auto side = static_cast<int>(part.rows());
  const auto takes_part = [&](int edge) {
    return (part.row(edge) > 0).any() || (part.row(side - 1 - edge) > 0).any() ||
           (part.col(edge) > 0).any() || (part.col(side - 1 - edge) > 0).any();
  };
  int border = 0;
  while (border < side / 2 && !takes_part(border)) ++border;
  return border;
}

}  // namespace

Image PutInPlace(const ImageWindow& part, int width, int height) {
  Image whole(width, height, kNoData);
  const int left = static_cast<int>(part.origin.x()), top = static_cast<int>(part.origin.y());
  const int first = std::max(0, -left), stop = std::min(part.image.width, width - left);
  for (int row = std::max(0, -top); row < std::min(part.image.height, height - top); ++row)
    if (first < stop)
      std::copy(part.image.Row(row) + first, part.image.Row(row) + stop,
                whole.Row(row + top) + first + left);
  return whole;
}

MatchingDrawing::MatchingDrawing(const MarkShape& shape, const Matrix2d& pixel_from_mm)
    : background_px_(kBackgroundSigmaMm * PixelsPerMm(pixel_from_mm)) {
  const double margin_mm = RenderOptions().margin_mm + kMarginPx / PixelsPerMm(pixel_from_mm);
  FloatPlane fine = DrawFinely(shape, pixel_from_mm, margin_mm);
  const FloatPlane drawn = InWholePixels(fine);
  part_ = PartOf(shape, pixel_from_mm, margin_mm, drawn);
  border_ = EmptyBorder(part_);
  const auto part = std::make_shared<const DrawingPart>(part_);
  // A picture is continued by its mean.
  float fill = 0;
  if (shape.picture) fill = (part_ > 0).select(drawn, 0.0f).sum() / std::max(part_.sum(), 1.0f);
  DrawRough(drawn, fill, part);
  const FloatPlane filled = Padded(drawn, 0, fill);
  fine = Padded(fine, 0, fill) - fill - InFinePixels(BackgroundOf(filled - fill));
  sharp_.emplace(fine, kFiner, part);
}

FloatPlane MatchingDrawing::PartOf(const MarkShape& shape, const Matrix2d& pixel_from_mm,
                                   double margin_mm, const FloatPlane& drawn) const {
  const Index side = drawn.rows(), middle = side / 2;
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  std::vector<bool> near;
  if (!shape.picture)
    near = NearStrokes(shape.drawing, mm_from_pixel, static_cast<int>(middle), margin_mm);
  FloatPlane part = FloatPlane::Zero(side, side);
  for (Index row = 0; row < side; ++row)
    for (Index col = 0; col < side; ++col) {
      const Vector2d offset(static_cast<double>(col - middle), static_cast<double>(row - middle));
      const bool used = shape.picture ? (mm_from_pixel * offset).norm() <= MarkRadius(shape)
                                      : near[static_cast<size_t>(row * side + col)];
      if (used && std::isfinite(drawn(row, col))) part(row, col) = 1;
    }
  return part;
}

void MatchingDrawing::DrawRough(const FloatPlane& drawn, float fill,
                                std::shared_ptr<const DrawingPart> part) {
  const auto pad = static_cast<Index>(std::ceil(2 * background_px_));
  const Image flat = RemoveBackground(AsImage(Padded(drawn, pad, fill)), background_px_);
  const SharpDrawing sharp(AsPlane(flat).block(pad, pad, drawn.rows(), drawn.cols()), 1,
                           std::move(part));
  for (const double blur : kRoughBlurs) rough_.push_back({blur, sharp.Blurred(blur)});
}

// Background of the mark's own pixels alone, extended by some pixels.
FloatPlane MatchingDrawing::BackgroundOf(const FloatPlane& drawn) const {
  const auto side = static_cast<int>(drawn.rows());
  ImageWindow alone = CutOut(AsImage(drawn), Vector2d::Constant(HalfSide()));
  alone.image = RemoveBackground(alone.image, background_px_);
  return Extended(drawn - AsPlane(PutInPlace(alone, side, side)), kSupportPx);
}

int MatchingDrawing::StepOf(double blur_px) {
  return static_cast<int>(std::lround(std::log(blur_px / kSharpest) / std::log(kStep)));
}

const MatchingDrawing::Level& MatchingDrawing::Fine(int step) const {
  const std::lock_guard lock(mutex_);
  const auto known = fine_.find(step);
  if (known != fine_.end()) return known->second;
  const double blur = kSharpest * std::pow(kStep, step);
  return fine_.emplace(step, Level{blur, sharp_->Blurred(blur)}).first->second;
}

ImageWindow MatchingDrawing::CutOut(const Image& seen, const Vector2d& centre) const {
  const auto side = static_cast<int>(part_.rows()), inner = side - 2 * border_;
  ImageWindow cut{Image(inner, inner, kNoData), (centre.array() - 0.5 * side).round() + border_, 1};
  const int left = static_cast<int>(cut.origin.x()), top = static_cast<int>(cut.origin.y());
  for (int row = std::max(0, -top); row < std::min(inner, seen.height - top); ++row)
    for (int col = std::max(0, -left); col < std::min(inner, seen.width - left); ++col)
      if (part_(row + border_, col + border_) > 0)
        cut.image.At(col, row) = seen.At(col + left, row + top);
  return cut;
}

}  // namespace orient::interior
