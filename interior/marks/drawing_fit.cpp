#include "interior/marks/drawing_fit.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/matching/correlation.h"
#include "core/raster/resample.h"
#include "interior/marks/fitted_parts.h"
#include "interior/marks/mark_drawing.h"

namespace orient::interior {
namespace {

using Eigen::Vector2d;
using Elements = std::vector<MarkElement>;

constexpr double kMargin_mm = 0.35;  // around the strokes, as in RenderOptions
constexpr double kNoScore = -2;      // of what cannot be drawn

MarkShape ShapeOf(const Elements& elements) {
  MarkShape shape;
  shape.drawing.elements = elements;
  return shape;
}

// Minus the best-fitting plane: fog and vignetting are not part of a mark.
Image WithoutSlope(Image image) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();  // of 1, col, row; its upper triangle
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (int row = 0; row < image.height; ++row) {
    double n = 0, cols = 0, squares = 0, values = 0, moments = 0;
    for (int col = 0; col < image.width; ++col) {
      const auto value = static_cast<double>(image.At(col, row));
      if (!std::isfinite(value)) continue;
      n += 1;
      cols += col;
      squares += col * col;
      values += value;
      moments += col * value;
    }
    normal.row(0) += Eigen::RowVector3d(n, cols, row * n);
    normal(1, 1) += squares;
    normal(1, 2) += row * cols;
    normal(2, 2) += row * (row * n);
    right += Eigen::Vector3d(values, moments, row * values);
  }
  normal.triangularView<Eigen::StrictlyLower>() = normal.transpose();
  if (std::abs(normal.determinant()) < 1e-6) return image;
  const Eigen::Vector3d plane = normal.inverse() * right;
  for (int row = 0; row < image.height; ++row) {
    const double first = plane(0) + plane(2) * row;
    for (int col = 0; col < image.width; ++col)
      image.At(col, row) -= static_cast<float>(first + plane(1) * col);
  }
  return image;
}

// The marks seen within `half_mm` of their centre, at no more than `most_px` pixels from the middle
// to a side.
class Window {
 public:
  Window(const std::vector<SeenMark>& marks, double half_mm, int most_px) : half_mm_(half_mm) {
    for (const SeenMark& mark : marks) views_.push_back(ViewOf(mark, most_px));
  }

  // Every mark's correlation and centre; kNoScore for a drawing that does not fit in.
  FittedDrawing Locate(const Elements& elements) const {
    FittedDrawing located{elements, {}, {}};
    const bool drawable = IsDrawable(elements);
    const MarkShape shape = ShapeOf(elements);
    const double radius = MarkRadius(shape);
    for (const View& view : views_) {
      located.centre.push_back(view.near);
      located.correlation.push_back(kNoScore);
      const bool too_thin = ThinnestStroke(shape) * view.pixels_per_mm < 0.3;
      if (!drawable || radius > half_mm_ || too_thin) continue;
      const MarkTemplate drawn = Rendered(shape, view);
      const auto peaks = FindPeaks(Correlate(drawn.values, view.image), 1, 1, -1.0);
      if (peaks.empty()) continue;
      located.correlation.back() = peaks[0].score;
      located.centre.back() = view.origin + view.reduced * (peaks[0].position + drawn.centre);
    }
    return located;
  }

  // Bayesian information criterion, relative to no drawing at all; the less the better. A further
  // element must also explain a share of what is left, for the fit's own blur is never the scan's.
  double Criterion(const Parts& parts) const {
    const FittedDrawing located = Locate(Drawn(parts));
    constexpr double kLeastGain = 0.12;
    double independent = 0, misfit = 0;
    for (size_t i = 0; i < views_.size(); ++i) {
      const double score = located.correlation[i];
      if (score <= 0) return 0;
      misfit += views_[i].independent * std::log(std::max(1 - score * score, 1e-6));
      independent += views_[i].independent;
    }
    return misfit + static_cast<double>(ParameterCount(parts)) * std::log(independent) +
           kLeastGain * static_cast<double>(parts.size()) * independent;
  }

  double half_mm() const { return half_mm_; }

 private:
  struct View {
    Image image;  // of the size in which the template moves by the mark's reach
    Vector2d origin, near;
    double reduced = 1;
    Eigen::Matrix2d pixel_from_mm;
    double pixels_per_mm = 1;
    double independent = 0;  // number of pixels with independent errors
  };

  View ViewOf(const SeenMark& mark, int most_px) const {
    constexpr double kPixelsPerError = 6;  // blur and grain correlate the errors of neighbours
    View view;
    view.near = mark.near;
    const double full = std::sqrt(std::abs(mark.pixel_from_mm.determinant()));
    view.reduced = std::max(1.0, half_mm_ * full / most_px);
    view.pixel_from_mm = mark.pixel_from_mm / view.reduced;
    view.pixels_per_mm = full / view.reduced;
    const double template_px = std::ceil(half_mm_ * view.pixels_per_mm * 1.03 + 0.5);
    const double half_px = template_px + std::ceil(mark.reach_px / view.reduced);
    view.independent = 4 * template_px * template_px / kPixelsPerError;
    const int side = static_cast<int>(std::ceil((2 * half_px + 2) * view.reduced));
    const int col = static_cast<int>(std::floor(mark.near.x() - 0.5 * side));
    const int row = static_cast<int>(std::floor(mark.near.y() - 0.5 * side));
    Image cut(side, side, kNoData);
    for (int r = std::max(0, -row); r < side && r + row < mark.image.height; ++r)
      for (int c = std::max(0, -col); c < side && c + col < mark.image.width; ++c)
        cut.At(c, r) = mark.image.At(c + col, r + row);
    view.origin = Vector2d(col, row);
    view.image = WithoutSlope(view.reduced > 1 ? ReduceBy(cut, view.reduced) : cut);
    return view;
  }

  MarkTemplate Rendered(const MarkShape& shape, const View& view) const {
    RenderOptions options;
    options.margin_mm = half_mm_ - MarkRadius(shape);
    options.supersampling = 3;
    options.whole_square = true;
    MarkTemplate drawn = RenderMark(shape, view.pixel_from_mm, options);
    drawn.values = WithoutSlope(std::move(drawn.values));
    return drawn;
  }

  double half_mm_;
  std::vector<View> views_;
};

// A pattern search (Hooke & Jeeves) in all parameters of all parts.
double Improve(const Window& window, Parts* parts) {
  constexpr double kFirstStep = 0.16, kLastStep = 0.01;
  double best = window.Criterion(*parts);
  for (double step = kFirstStep; step >= kLastStep; step /= 2) {
    for (bool better = true; better;) {
      better = false;
      for (Part& part : *parts)
        for (double& parameter : part.parameters)
          for (const double change : {step, -step}) {
            const double before = parameter;
            parameter += change;
            const double criterion = window.Criterion(*parts);
            if (criterion < best - 1e-9) {
              best = criterion;
              better = true;
              break;
            }
            parameter = before;
          }
    }
  }
  return best;
}

struct Candidate {
  Parts parts;
  double criterion = 0;
};

// With one more element of this shape and brightness: the best of its starting values.
Candidate BestStart(const Window& window, const Parts& parts, size_t shape, double brightness) {
  Candidate best;
  for (const std::vector<double>& start : StartsOf(shape, window.half_mm())) {
    Parts with = parts;
    with.push_back({shape, brightness, start});
    const double criterion = window.Criterion(with);
    if (best.parts.empty() || criterion < best.criterion) best = {with, criterion};
  }
  return best;
}

// With one more element; the best starts are improved.
Candidate WithOneMore(const Window& window, const Parts& parts) {
  constexpr size_t kImproved = 3;
  // A cross on a bright disc is as bright as the surroundings, or darker than these.
  const std::vector<double> brightnesses =
      parts.empty() ? std::vector<double>{1, -1}
                    : std::vector<double>{parts[0].brightness, 0, -parts[0].brightness};
  std::vector<Candidate> candidates;
  for (size_t shape = 0; shape < kFittedShapes; ++shape)
    for (const double brightness : brightnesses)
      candidates.push_back(BestStart(window, parts, shape, brightness));
  std::sort(candidates.begin(), candidates.end(),
            [](const Candidate& a, const Candidate& b) { return a.criterion < b.criterion; });
  candidates.resize(std::min(candidates.size(), kImproved));
  for (Candidate& candidate : candidates) candidate.criterion = Improve(window, &candidate.parts);
  return *std::min_element(
      candidates.begin(), candidates.end(),
      [](const Candidate& a, const Candidate& b) { return a.criterion < b.criterion; });
}

Parts FitIn(const Window& window) {
  constexpr size_t kMostElements = 3;
  Candidate best;
  while (best.parts.size() < kMostElements) {
    const Candidate more = WithOneMore(window, best.parts);
    if (more.criterion >= best.criterion) break;
    best = more;
  }
  return best.parts;
}

// Without the elements that explain too little.
void Prune(const Window& window, Parts* parts) {
  double criterion = window.Criterion(*parts);
  for (size_t i = parts->size(); i-- > 0 && parts->size() > 1;) {
    Parts without = *parts;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    const double then = window.Criterion(without);
    if (then > criterion) continue;
    criterion = then;
    *parts = without;
  }
}

constexpr int kPixelsSearched = 24, kPixelsMeasured = 60;

// The window of the strokes with a small margin.
Window WindowOf(const Elements& elements, const std::vector<SeenMark>& marks, int most_px) {
  return {marks, MarkRadius(ShapeOf(elements)) + kMargin_mm, most_px};
}

// Fits in the largest window that is explained about as well as the best one.
Parts FitInLargestWindow(const std::vector<SeenMark>& marks) {
  constexpr std::array<double, 5> kWindows_mm = {0.6, 0.95, 1.5, 2.4, kLargestFittedRadius_mm};
  constexpr double kAboutAsWell = 0.03;
  std::vector<std::pair<Parts, double>> fits;
  double best = 0;
  for (const double half_mm : kWindows_mm) {
    const Window window(marks, half_mm, kPixelsSearched);
    Parts parts = FitIn(window);
    if (parts.empty()) continue;
    Prune(window, &parts);
    fits.emplace_back(parts, window.Locate(Drawn(parts)).MeanCorrelation());
    best = std::max(best, fits.back().second);
  }
  if (fits.empty()) return {};
  return std::find_if(fits.rbegin(), fits.rend(),
                      [&](const auto& fit) { return fit.second >= best - kAboutAsWell; })
      ->first;
}

// The same or another drawing, fitted in the window that the first one needs.
Parts FittedAnew(const Parts& parts, const std::vector<SeenMark>& marks) {
  const Window window = WindowOf(Drawn(parts), marks, kPixelsSearched);
  Parts improved = parts, anew = FitIn(window);
  const double criterion = Improve(window, &improved);
  if (anew.empty() || window.Criterion(anew) > criterion) anew = improved;
  Prune(window, &anew);
  return anew;
}

}  // namespace

SeenMark CutMark(const Raster& scan, const Vector2d& pixel, const Eigen::Matrix2d& pixel_from_mm,
                 const CutOptions& options, ImageWindow* window) {
  const double pixels_per_mm = std::sqrt(std::abs(pixel_from_mm.determinant()));
  const int half = static_cast<int>(
      std::ceil(options.radius_mm * pixels_per_mm + options.reach_px + 2 * options.reduction));
  ImageWindow cut =
      scan.ReadGrey({static_cast<int>(std::floor(pixel.x())) - half,
                     static_cast<int>(std::floor(pixel.y())) - half, 2 * half + 1, 2 * half + 1},
                    options.reduction);
  SeenMark seen;
  seen.near = cut.ImageFromRaster(pixel);
  seen.pixel_from_mm = pixel_from_mm / cut.scale;
  seen.reach_px = options.reach_px / cut.scale;
  seen.image = std::move(cut.image);
  if (options.negative)
    for (float& value : seen.image.values) value = -value;
  if (window != nullptr) *window = {Image(), cut.origin, cut.scale};
  return seen;
}

double FittedDrawing::MeanCorrelation() const {
  double sum = 0;
  for (const double one : correlation) sum += one;
  return sum / static_cast<double>(correlation.size());
}

std::optional<FittedDrawing> FitDrawing(const std::vector<SeenMark>& marks) {
  constexpr double kLeastCorrelation = 0.5;
  if (marks.empty()) return std::nullopt;
  Parts parts = FitInLargestWindow(marks);
  if (parts.empty()) return std::nullopt;
  parts = FittedAnew(parts, marks);
  const Window window = WindowOf(Drawn(parts), marks, kPixelsMeasured);
  Improve(window, &parts);
  Prune(window, &parts);
  Elements elements = Drawn(parts), rounded = elements;
  RoundLengths(&rounded);
  if (IsDrawable(rounded)) elements = rounded;
  FittedDrawing fitted = LocateDrawing(elements, marks);
  if (fitted.MeanCorrelation() < kLeastCorrelation) return std::nullopt;
  return fitted;
}

FittedDrawing LocateDrawing(const std::vector<MarkElement>& elements,
                            const std::vector<SeenMark>& marks, double radius_mm) {
  const double reach_mm = std::max(radius_mm, RadiusOf(elements)) + kMargin_mm;
  return Window(marks, reach_mm, kPixelsMeasured).Locate(elements);
}

double RadiusOf(const std::vector<MarkElement>& elements) { return MarkRadius(ShapeOf(elements)); }

}  // namespace orient::interior
