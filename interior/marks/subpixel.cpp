#include "interior/marks/subpixel.h"

#include <algorithm>
#include <cmath>

#include "interior/marks/match_precision.h"
#include "interior/marks/matching_drawing.h"

namespace orient::interior {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Level = MatchingDrawing::Level;

// Error that remains without any grain (outlines, spline; simulated scans: 0.0004 to 0.0009 px).
constexpr double kFloor_px = 0.0005;

// Convergence, as a share of the blur, that suffices to compare blurs by their correlation.
constexpr double kNear = 0.04;

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

// Makes strokes bright, as in the drawing.
void MakePositive(Image* image, Polarity polarity) {
  if (polarity == Polarity::kPositive) return;
  for (float& value : image->values) value = -value;
}

// Matches at several blurs; the best correlation wins, each starts where the last one ended.
struct Trials {
  const SeenPlane& seen;
  Vector2d first;
  double max_shift_px;
  Steps steps;
  Vector2d from = first;
  std::optional<DrawingMatch> best = std::nullopt;
  const Level* level = nullptr;  // of the best one
  std::vector<Sharpness> tried = {};

  void Try(const Level& next) {
    const auto match = next.moving.Match(seen, from, max_shift_px, kNear * next.blur_px, steps);
    if (!match || match->correlation <= 0 || (match->centre - first).norm() > max_shift_px) return;
    from = match->centre;
    tried.push_back({next.blur_px, match->correlation});
    if (best && best->correlation >= match->correlation) return;
    best = match;
    level = &next;
  }
};

// Tries blurs a quarter apart, from `blur_px` on, until the best one lies between others; then the
// interpolated best one, as residuals of a wrong blur at the strokes' edges would count as noise.
void FindBlur(const MatchingDrawing& drawing, double blur_px, Trials* trials) {
  constexpr int kApart = 11;  // steps
  const int start = MatchingDrawing::StepOf(blur_px);
  int widest = start + kApart, sharpest = start - kApart;
  const auto try_step = [&](int step) { trials->Try(drawing.Fine(step)); };
  const auto is_best = [&](int step) { return trials->level == &drawing.Fine(step); };
  for (const int step : {widest, start, sharpest}) try_step(step);
  while (sharpest > 0 && is_best(sharpest)) try_step(sharpest -= kApart);
  while (widest < start + 3 * kApart && is_best(widest)) try_step(widest += kApart);
  std::sort(trials->tried.begin(), trials->tried.end(),
            [](const Sharpness& a, const Sharpness& b) { return a.blur_px > b.blur_px; });
  if (const auto blur = BetweenBlurs(trials->tried)) try_step(MatchingDrawing::StepOf(*blur));
}

// `plane`: `seen` without its background.
std::optional<MarkPosition> MeasureBy(Steps steps, const MatchingDrawing& drawing,
                                      const ImageWindow& seen, const SeenPlane& plane,
                                      const Vector2d& start, double max_shift_px) {
  Trials rough{plane, seen.ImageFromRaster(start), max_shift_px, steps};
  for (const Level& level : drawing.Rough()) rough.Try(level);
  if (!rough.best) return std::nullopt;

  // Without its surroundings: a bright picture there would affect the background.
  const Vector2d middle = Vector2d::Constant(drawing.HalfSide());
  const Vector2d corner = (rough.best->centre - middle).array().round();
  ImageWindow mark = drawing.CutOut(seen.image, corner + middle);
  mark.image = RemoveBackground(mark.image, drawing.BackgroundPx());
  const SeenPlane alone(PutInPlace(mark, seen.image.width, seen.image.height));
  constexpr double kFarthest_px = 1, kConverged_px = 1e-3;
  Trials fine{alone, rough.best->centre, kFarthest_px, steps};
  FindBlur(drawing, rough.level->blur_px, &fine);
  if (fine.best)
    fine.best =
        fine.level->moving.Match(alone, fine.best->centre, kFarthest_px, kConverged_px, steps);
  if (!fine.best || fine.best->correlation <= 0) return std::nullopt;
  const Vector2d centre = fine.best->centre;
  const Vector2d whole = (centre - middle).array().round();
  const auto precision = PrecisionOfMatch(
      mark.image, fine.level->moving.Moved(centre - middle - whole), mark.origin - whole);
  if (!precision) return std::nullopt;
  const Matrix2d with_floor = precision->covariance + kFloor_px * kFloor_px * Matrix2d::Identity();
  return MarkPosition{.pixel = seen.RasterFromImage(centre),
                      .covariance = with_floor,
                      .correlation = fine.best->correlation,
                      .correlation_without_grain = precision->correlation_without_grain,
                      .gain_over_sigma = precision->gain_over_sigma,
                      .blur_sigma_px = fine.level->blur_px};
}

}  // namespace

MarkMeasurer::MarkMeasurer(const MarkShape& shape, const Matrix2d& pixel_from_mm)
    : drawn_(std::make_unique<const MatchingDrawing>(shape, pixel_from_mm)) {}
MarkMeasurer::~MarkMeasurer() = default;
MarkMeasurer::MarkMeasurer(MarkMeasurer&&) noexcept = default;
MarkMeasurer& MarkMeasurer::operator=(MarkMeasurer&&) noexcept = default;

std::optional<MarkPosition> MarkMeasurer::Measure(const Raster& scan, const Vector2d& start,
                                                  Polarity polarity, double max_shift_px) const {
  const double background_px = drawn_->BackgroundPx();
  const double reach = drawn_->HalfSide() + std::max(max_shift_px + 1, background_px);
  ImageWindow seen = ReadAround(scan, start, static_cast<int>(std::ceil(reach)));
  MakePositive(&seen.image, polarity);
  const SeenPlane plane(RemoveBackground(seen.image, background_px));
  // Scaled steps can converge even beside a mark: used only if plain ones do not converge.
  for (const Steps steps : {Steps::kPlain, Steps::kScaled})
    if (const auto position = MeasureBy(steps, *drawn_, seen, plane, start, max_shift_px))
      return position;
  return std::nullopt;
}

std::optional<MarkPosition> MeasureMark(const Raster& scan, const MarkShape& shape,
                                        const Matrix2d& pixel_from_mm, const Vector2d& start,
                                        Polarity polarity, double max_shift_px) {
  return MarkMeasurer(shape, pixel_from_mm).Measure(scan, start, polarity, max_shift_px);
}

}  // namespace orient::interior
