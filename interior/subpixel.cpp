#include "interior/subpixel.h"

#include <Eigen/LU>
#include <deque>
#include <utility>

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
constexpr double kSharpest = 0.3;
// What is left without any grain (outlines, spline; simulated scans: 0.0004 to 0.0009 px).
constexpr double kFloor_px = 0.0005;

// Optics blur before a scanner's pixels average; the other way round strokes of two pixels are
// aliased (by 0.005 px). So many finer pixels per axis are blurred, each of so many samples.
constexpr int kFiner = 2, kSamples = 2;

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

// A drawing in pixels of half the size: those of even and odd rows, of these the even and the odd
// columns, each plane as large as the drawing in whole pixels.
using FinePlanes = std::array<std::array<FloatPlane, kFiner>, kFiner>;

FloatPlane Padded(const FloatPlane& plane, Index by) {
  FloatPlane padded = FloatPlane::Zero(plane.rows() + 2 * by, plane.cols() + 2 * by);
  padded.block(by, by, plane.rows(), plane.cols()) = plane;
  return padded;
}

// In whole pixels, blurred (`sigma` in fine ones) before they are averaged; zero beyond the border.
FloatPlane BlurredAndAveraged(const FinePlanes& fine, double sigma) {
  const auto half = static_cast<Index>(std::ceil(2 * sigma)), reach = 2 * half;
  const auto gauss = [sigma](Index i) {
    return static_cast<float>(std::exp(-0.5 * static_cast<double>(i * i) / (sigma * sigma)));
  };
  // Of the fine pixels from `reach` before a pixel's first one to `reach` behind its second one.
  Eigen::ArrayXf even(reach + 1);
  for (Index i = 0; i <= reach; ++i) even[i] = gauss(2 * i - reach) + gauss(2 * i - reach - 1);
  even /= 2 * even.sum();
  const Eigen::ArrayXf odd = even.reverse();
  const auto across = [&](const std::array<FloatPlane, kFiner>& rows) {
    return FloatPlane(FloatSums(even.transpose(), Padded(rows[0], half)) +
                      FloatSums(odd.transpose(), Padded(rows[1], half)));
  };
  return FloatSums(even, across(fine[0])) + FloatSums(odd, across(fine[1]));
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

struct Sharpness {
  double blur_px = 0, correlation = 0;
};

// The blur between the tried ones at which a parabola through the best one and its neighbours has
// its top; `tried` goes from the widest to the sharpest. Diffusion is linear in the blur's square,
// so the squared misfit is nearly a parabola in it. Empty where the best one has no neighbour on
// one side.
std::optional<double> BetweenBlurs(const std::vector<Sharpness>& tried) {
  const auto best = std::max_element(
      tried.begin(), tried.end(),
      [](const Sharpness& a, const Sharpness& b) { return a.correlation < b.correlation; });
  if (tried.size() < 3 || best == tried.begin() || best + 1 == tried.end()) return std::nullopt;
  const auto square = [](const Sharpness& s) { return s.blur_px * s.blur_px; };
  const double x = square(*best), y = best->correlation;
  const double a = square(*(best - 1)) - x, fall_a = y - (best - 1)->correlation;
  const double b = square(*(best + 1)) - x, fall_b = y - (best + 1)->correlation;
  // fall = c (offset - top)^2 - c top^2
  const double down = a * fall_b - b * fall_a;
  if (!(std::abs(down) > 0)) return std::nullopt;
  const double top = 0.5 * (a * a * fall_b - b * b * fall_a) / down;
  return std::sqrt(x + std::clamp(top, std::min(a, b), std::max(a, b)));
}

FloatPlane AsPlane(const Image& image) {
  return Eigen::Map<const FloatPlane>(image.values.data(), image.height, image.width);
}

// A part in its place, no data elsewhere.
Image Put(const ImageWindow& part, int width, int height) {
  Image whole(width, height, kNoData);
  const int left = static_cast<int>(part.origin.x()), top = static_cast<int>(part.origin.y());
  for (int row = 0; row < part.image.height; ++row)
    for (int col = 0; col < part.image.width; ++col) {
      const int c = col + left, r = row + top;
      if (c >= 0 && r >= 0 && c < width && r < height) whole.At(c, r) = part.image.At(col, row);
    }
  return whole;
}

// Mean of the pixel's neighbours that have a value; it has some.
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

// Values for the pixels without one, from those beside them, `steps` pixels far and zero beyond.
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

// Half the differences of the columns beside each column, or one at the border.
FloatPlane SlopeAcross(const FloatPlane& plane) {
  const Index last = plane.cols() - 1;
  FloatPlane slope(plane.rows(), plane.cols());
  slope.middleCols(1, last - 1) = 0.5f * (plane.rightCols(last - 1) - plane.leftCols(last - 1));
  slope.col(0) = 0.5f * (plane.col(1) - plane.col(0));
  slope.col(last) = 0.5f * (plane.col(last) - plane.col(last - 1));
  return slope;
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
    MovingDrawing moving;
    FloatPlane values = {};  // of a drawing that was drawn where it lies
  };

  Drawn(const MarkShape& of_shape, const Matrix2d& of_pixel_from_mm);

  // The drawing before any blur of the scanner's with its centre `fraction` from the middle.
  struct Moved {
    FinePlanes fine;  // `fill` taken off
    FloatPlane background;
  };
  Moved Move(const Vector2d& fraction) const;
  Level Blur(const Moved& moved, double blur_px) const;

  // The scan where the drawing's pixels take part, its centre at `centre`; no larger than they
  // need.
  ImageWindow CutOut(const Image& seen, const Vector2d& centre) const;

  const MarkShape& shape;
  Matrix2d pixel_from_mm;
  double margin_mm = 0;
  double background_px = 0;
  FloatPlane part;  // pixels that take part
  std::shared_ptr<const DrawingPart> moving_part;
  FloatPlane background;                         // slow brightness of these pixels alone
  FloatPlane background_right, background_down;  // its slopes
  int border = 0;                                // so many outermost rows and columns take no part
  float fill = 0;                                // beyond the drawing
  std::vector<Level> levels;

 private:
  MarkTemplate Render(int finer, const Vector2d& offset) const;
};

MarkMeasurer::Drawn::Level MarkMeasurer::Drawn::Blur(const Moved& moved, double blur_px) const {
  const FloatPlane blurred =
      BlurredAndAveraged(moved.fine, kFiner * blur_px) - moved.background + fill;
  return {blur_px, MovingDrawing(blurred, moving_part), blurred};
}

MarkTemplate MarkMeasurer::Drawn::Render(int finer, const Vector2d& offset) const {
  RenderOptions render;
  render.blur_sigma_px = 0;
  render.margin_mm = margin_mm + kSupportPx / PixelsPerMm(pixel_from_mm);
  render.offset_px = offset;
  render.supersampling = kFiner * kSamples / finer;
  render.smooth_outlines = true;
  return RenderMark(shape, finer * pixel_from_mm, render);
}

MarkMeasurer::Drawn::Moved MarkMeasurer::Drawn::Move(const Vector2d& fraction) const {
  // An odd side's middle is a corner of finer pixels, and a template's a pixel's centre.
  const Image drawn = Render(kFiner, kFiner * fraction - Vector2d::Constant(0.5)).values;
  const auto side = static_cast<int>(part.rows());
  const int first = side - drawn.width / 2;
  Moved moved;
  for (auto& rows : moved.fine) rows.fill(FloatPlane::Zero(side, side));
  for (int row = std::max(0, first); row < std::min(kFiner * side, first + drawn.height); ++row)
    for (int col = std::max(0, first); col < std::min(kFiner * side, first + drawn.width); ++col) {
      const float value = drawn.At(col - first, row - first);
      if (!std::isfinite(value)) continue;
      moved.fine[static_cast<size_t>(row % kFiner)][static_cast<size_t>(col % kFiner)](
          row / kFiner, col / kFiner) = value - fill;
    }
  // So smooth that its slope moves it.
  moved.background = background - static_cast<float>(fraction.x()) * background_right -
                     static_cast<float>(fraction.y()) * background_down;
  return moved;
}

MarkMeasurer::Drawn::Drawn(const MarkShape& of_shape, const Matrix2d& of_pixel_from_mm)
    : shape(of_shape), pixel_from_mm(of_pixel_from_mm) {
  const double pixels_per_mm = PixelsPerMm(pixel_from_mm);
  background_px = kBackgroundSigmaMm * pixels_per_mm;
  margin_mm = RenderOptions().margin_mm + kMarginPx / pixels_per_mm;
  const MarkTemplate drawn = Render(1, Vector2d::Zero());
  const int side = drawn.values.width;
  const Matrix2d mm_from_pixel = pixel_from_mm.inverse();
  std::vector<bool> near;
  if (!shape.picture) near = NearStrokes(shape.drawing, mm_from_pixel, side / 2, margin_mm);
  part = FloatPlane::Zero(side, side);
  double sum = 0, count = 0;
  for (int row = 0; row < side; ++row) {
    for (int col = 0; col < side; ++col) {
      const Vector2d mm = mm_from_pixel * (Vector2d(col + 0.5, row + 0.5) - drawn.centre);
      const bool used = shape.picture ? mm.norm() <= MarkRadius(shape)
                                      : near[static_cast<size_t>(row * side + col)];
      if (!used || !std::isfinite(drawn.values.At(col, row))) continue;
      part(row, col) = 1;
      sum += static_cast<double>(drawn.values.At(col, row));
      ++count;
    }
  }
  const auto takes_part = [&](int edge) {
    return (part.row(edge) > 0).any() || (part.row(side - 1 - edge) > 0).any() ||
           (part.col(edge) > 0).any() || (part.col(side - 1 - edge) > 0).any();
  };
  while (border < side / 2 && !takes_part(border)) ++border;
  const int pad = static_cast<int>(std::ceil(2 * background_px));
  if (shape.picture) fill = static_cast<float>(sum / std::max(count, 1.0));
  const Image padded = Padded(drawn.values, pad, fill);
  const Image flat = RemoveBackground(padded, background_px);
  FloatPlane plane(side, side), whole(side, side);
  for (int row = 0; row < side; ++row)
    for (int col = 0; col < side; ++col) {
      plane(row, col) = flat.At(col + pad, row + pad);
      whole(row, col) = padded.At(col + pad, row + pad);
    }
  const Vector2d middle = Vector2d::Constant(0.5 * side);
  ImageWindow alone = CutOut(AsImage(whole), middle);
  alone.image = RemoveBackground(alone.image, background_px);
  background = Extended(whole - AsPlane(Put(alone, side, side)), kSupportPx);
  background_right = SlopeAcross(background);
  background_down = SlopeAcross(background.transpose()).transpose();
  moving_part = std::make_shared<DrawingPart>(part);
  const MovingDrawing sharp(plane, moving_part);
  for (const double blur : kBlurs) levels.push_back({blur, sharp.Blurred(blur)});
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

// Matches at several blurs; the best correlation wins, each starts where the last one ended.
struct MarkMeasurer::Trials {
  const SeenPlane& seen;
  Vector2d first;
  double max_shift_px;
  Vector2d from = first;
  std::optional<DrawingMatch> best = std::nullopt;
  const Drawn::Level* level = nullptr;  // of the best one
  std::vector<Sharpness> tried = {};

  void Try(const Drawn::Level& next) {
    const auto match = next.moving.Match(seen, from, max_shift_px, kNear * next.blur_px);
    if (!match || match->correlation <= 0 || (match->centre - first).norm() > max_shift_px) return;
    from = match->centre;
    tried.push_back({next.blur_px, match->correlation});
    if (best && best->correlation >= match->correlation) return;
    best = match;
    level = &next;
  }
};

std::optional<MarkPosition> MarkMeasurer::Measure(const Raster& scan, const Vector2d& start,
                                                  Polarity polarity, double max_shift_px) const {
  const Vector2d middle = Vector2d::Constant(0.5 * static_cast<double>(drawn_->part.rows()));
  const double reach = middle.x() + std::max(max_shift_px + 1, drawn_->background_px);
  ImageWindow seen = ReadAround(scan, start, static_cast<int>(std::ceil(reach)));
  MakePositive(&seen.image, polarity);
  const SeenPlane plane(RemoveBackground(seen.image, drawn_->background_px));
  Trials rough{plane, seen.ImageFromRaster(start), max_shift_px};
  for (const Drawn::Level& level : drawn_->levels) rough.Try(level);
  if (!rough.best) return std::nullopt;

  // A sharp drawing is not band-limited, and the spline that moves it errs by up to 0.015 px: it
  // is drawn anew where it was found to lie, which leaves next to nothing to be moved.
  const Vector2d corner = (rough.best->centre - middle).array().round();
  const Vector2d fraction = rough.best->centre - middle - corner;
  const Drawn::Moved drawing = drawn_->Move(fraction);
  // Without what lies beside it: a bright picture would be seen in the background.
  ImageWindow mark = drawn_->CutOut(seen.image, corner + middle);
  mark.image = RemoveBackground(mark.image, drawn_->background_px);
  const SeenPlane alone(Put(mark, seen.image.width, seen.image.height));
  constexpr double kFarthest_px = 1;
  Trials fine{alone, corner + middle, kFarthest_px};
  std::deque<Drawn::Level> levels;
  const auto try_blur = [&](double blur) {
    fine.Try(levels.emplace_back(drawn_->Blur(drawing, blur)));
  };
  constexpr double kStep = 1.25;
  double sharpest = rough.level->blur_px / kStep;
  for (const double factor : {kStep * kStep, kStep, 1.0, 1 / kStep})
    try_blur(factor * rough.level->blur_px);
  // The spline blurs, too: the drawing that is not moved may need another blur than the best above.
  while (fine.level && fine.level->blur_px < 1.01 * sharpest && sharpest > kSharpest)
    try_blur(sharpest /= kStep);
  // What a wrong blur leaves at the strokes' edges would count as noise.
  if (const auto blur = BetweenBlurs(fine.tried)) try_blur(*blur);
  if (fine.best) fine.best = fine.level->moving.Match(alone, fine.best->centre, kFarthest_px);
  if (!fine.best || fine.best->correlation <= 0) return std::nullopt;
  const Vector2d centre = fine.best->centre;
  const auto covariance =
      ShiftCovariance(mark.image, AsImage(fine.level->values), middle - centre + mark.origin);
  if (!covariance) return std::nullopt;
  const Matrix2d with_floor = *covariance + kFloor_px * kFloor_px * Matrix2d::Identity();
  return MarkPosition{seen.RasterFromImage(centre + fraction), with_floor, fine.best->correlation,
                      fine.level->blur_px};
}

std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Matrix2d& pixel_from_mm, const Vector2d& start,
                                        Polarity polarity, double max_shift_px) {
  return MarkMeasurer(shape, pixel_from_mm).Measure(scan, start, polarity, max_shift_px);
}

}  // namespace orient
