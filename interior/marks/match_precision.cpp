#include "interior/marks/match_precision.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

namespace orient::interior {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Plane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kFarthestLag = 3;
constexpr Index kAtATime = 4;                       // pixels
constexpr Index kBehind = kFarthestLag + kAtATime;  // zeros behind every row

// The matched pixels as planes with some zeros behind every row, zero where a pixel takes no part.
struct Pixels {
  Plane mask, seen, model, residual, gradient_x, gradient_y;
  double count = 0;
  double gain = 0, explained = 0;  // of the model; variance of gain * model
};

// Catmull-Rom's weights for a place at `t` between the second and the third of four pixels, for the
// value and its slope (core/raster/resample: the same surface).
struct CubicTaps {
  explicit CubicTaps(double at)
      : value{-0.5 * at * at * at + at * at - 0.5 * at, 1.5 * at * at * at - 2.5 * at * at + 1,
              -1.5 * at * at * at + 2 * at * at + 0.5 * at, 0.5 * at * at * at - 0.5 * at * at},
        slope{-1.5 * at * at + 2 * at - 0.5, 4.5 * at * at - 5 * at, -4.5 * at * at + 4 * at + 0.5,
              1.5 * at * at - at} {}
  Eigen::Array4d value, slope;
};

// Weighted sums of four neighbouring columns, or rows.
Plane Across(const Plane& plane, const Eigen::Array4d& weights) {
  const Eigen::Array4f w = weights.cast<float>();
  const Index n = plane.cols() - 3;
  return w[0] * plane.leftCols(n) + w[1] * plane.middleCols(1, n) + w[2] * plane.middleCols(2, n) +
         w[3] * plane.middleCols(3, n);
}
Plane Down(const Plane& plane, const Eigen::Array4d& weights) {
  const Eigen::Array4f w = weights.cast<float>();
  const Index n = plane.rows() - 3;
  return w[0] * plane.topRows(n) + w[1] * plane.middleRows(1, n) + w[2] * plane.middleRows(2, n) +
         w[3] * plane.middleRows(3, n);
}

// The shift is one and the same for all pixels.
Pixels Sample(const Image& image, const Image& model, const Vector2d& model_from_image) {
  const Plane zero = Plane::Zero(image.height, image.width + kBehind);
  Pixels pixels{zero, zero, zero, zero, zero, zero};
  if (model.width < 4 || model.height < 4) return pixels;
  const Vector2d whole = model_from_image.array().floor();
  const CubicTaps x(model_from_image.x() - whole.x()), y(model_from_image.y() - whole.y());
  const Plane drawn = Eigen::Map<const Plane>(model.values.data(), model.height, model.width);
  const Plane across = Across(drawn, x.value);
  const Plane value = Down(across, y.value), gradient_x = Down(Across(drawn, x.slope), y.value),
              gradient_y = Down(across, y.slope);
  // Pixel (c, r) of these planes lies between the model's pixels c + 1 and c + 2.
  const auto left = static_cast<Index>(whole.x()) - 1, top = static_cast<Index>(whole.y()) - 1;
  for (Index row = std::max<Index>(0, -top);
       row < std::min<Index>(image.height, value.rows() - top); ++row) {
    for (Index col = std::max<Index>(0, -left);
         col < std::min<Index>(image.width, value.cols() - left); ++col) {
      const float seen = image.At(static_cast<int>(col), static_cast<int>(row));
      const Index c = col + left, r = row + top;
      if (!std::isfinite(seen) || !std::isfinite(value(r, c))) continue;
      pixels.mask(row, col) = 1;
      pixels.seen(row, col) = seen;
      pixels.model(row, col) = value(r, c);
      pixels.gradient_x(row, col) = gradient_x(r, c);
      pixels.gradient_y(row, col) = gradient_y(r, c);
      ++pixels.count;
    }
  }
  return pixels;
}

double Sum(const Plane& a) { return static_cast<double>(a.sum()); }

// seen = offset + gain * model + residual; the model becomes its difference from its mean,
// gradients those of gain * model.
bool Regress(Pixels* p) {
  const double n = p->count, m = Sum(p->model) / n, s = Sum(p->seen) / n;
  // Relative to the means, as squares of large grey values lose significant digits.
  const Plane model = (p->model - static_cast<float>(m)) * p->mask;
  const Plane seen = (p->seen - static_cast<float>(s)) * p->mask;
  const double variance = Sum(model.square());
  if (!(variance > 0)) return false;
  const auto gain = static_cast<float>(Sum(model * seen) / variance);
  p->residual = seen - gain * model;
  p->gradient_x *= gain;
  p->gradient_y *= gain;
  p->model = model;
  p->gain = static_cast<double>(gain);
  p->explained = p->gain * p->gain * variance / n;
  return true;
}

// Sums of products of pixels with those `dc`, `dr` pixels on; dr >= 0.
struct LagSums {
  double pairs = 0, residual = 0, model = 0, xx = 0, xy = 0, yy = 0;
};

LagSums SumsAtLag(const Pixels& p, Index dc, Index dr) {
  using Few = Eigen::Array<float, kAtATime, 1>;
  const Index here = std::max<Index>(0, -dc), there = std::max<Index>(0, dc);
  LagSums sums;
  for (Index r = 0; r + dr < p.mask.rows(); ++r) {
    // The plane's values in this row, and those of the pixels `dc`, `dr` on.
    struct Line {
      Line(const Plane& plane, Index at, Index on)
          : values(plane.data() + at), on_values(plane.data() + on) {}
      Eigen::Map<const Few> At(Index c) const { return Eigen::Map<const Few>(values + c); }
      Eigen::Map<const Few> On(Index c) const { return Eigen::Map<const Few>(on_values + c); }
      const float *values, *on_values;
    };
    const Index at = r * p.mask.cols() + here, on = (r + dr) * p.mask.cols() + there;
    const Line mask(p.mask, at, on), left(p.residual, at, on), drawn(p.model, at, on);
    const Line x(p.gradient_x, at, on), y(p.gradient_y, at, on);
    Few pairs = Few::Zero(), residual = pairs, model = pairs, xx = pairs, xy = pairs, yy = pairs;
    for (Index c = 0; c < p.mask.cols() - kBehind; c += kAtATime) {
      pairs += mask.At(c) * mask.On(c);
      residual += left.At(c) * left.On(c);
      model += drawn.At(c) * drawn.On(c);
      xx += x.At(c) * x.On(c);
      xy += x.At(c) * y.On(c) + y.At(c) * x.On(c);
      yy += y.At(c) * y.On(c);
    }
    const auto add = [](const Few& row, double* sum) { *sum += static_cast<double>(row.sum()); };
    add(pairs, &sums.pairs);
    add(residual, &sums.residual);
    add(model, &sums.model);
    add(xx, &sums.xx);
    add(xy, &sums.xy);
    add(yy, &sums.yy);
  }
  return sums;
}

// The residuals' autocovariance some three pixels apart, of either sign: the largest of four
// directions, less what independent residuals show by chance.
double StructureOf(const Pixels& p, double variance) {
  constexpr std::array<std::array<Index, 2>, 4> kLags = {{{3, 0}, {0, 3}, {2, 2}, {-2, 2}}};
  double most = 0;
  for (const auto& lag : kLags) {
    const Index dc = lag[0], dr = lag[1];
    const Index left = std::max<Index>(0, -dc), on = std::max<Index>(0, dc);
    const Index rows = p.mask.rows() - dr, cols = p.mask.cols() - std::abs(dc);
    const auto here = [&](const Plane& plane) { return plane.block(0, left, rows, cols); };
    const auto there = [&](const Plane& plane) { return plane.block(dr, on, rows, cols); };
    const auto pairs = static_cast<double>((here(p.mask) * there(p.mask)).sum());
    if (pairs < 1) continue;
    const auto products = static_cast<double>((here(p.residual) * there(p.residual)).sum());
    most = std::max(most, std::abs(products / pairs) - variance / std::sqrt(pairs));
  }
  return most;
}

double ResidualVariance(const Pixels& p) { return Sum(p.residual.square()) / p.count; }

double WithoutGrain(const Pixels& p, double variance) {
  return std::sqrt(p.explained / (p.explained + StructureOf(p, variance)));
}

constexpr int kParameters = 4;

}  // namespace

std::optional<MatchPrecision> PrecisionOfMatch(const Image& image, const Image& model,
                                               const Vector2d& model_from_image) {
  Pixels pixels = Sample(image, model, model_from_image);
  if (pixels.count <= kParameters || !Regress(&pixels)) return std::nullopt;
  Matrix2d normal, spread = Matrix2d::Zero();
  const double xy = Sum(pixels.gradient_x * pixels.gradient_y);
  normal << Sum(pixels.gradient_x.square()), xy, xy, Sum(pixels.gradient_y.square());
  const double variance = ResidualVariance(pixels);
  double gain_spread = 0;
  for (Index dr = 0; dr <= kFarthestLag; ++dr)
    for (Index dc = dr == 0 ? 0 : -kFarthestLag; dc <= kFarthestLag; ++dc) {
      const LagSums sums = SumsAtLag(pixels, dc, dr);
      if (sums.pairs < 1) continue;
      const double autocovariance = sums.residual / sums.pairs;
      const double with_opposite = dc == 0 && dr == 0 ? 1 : 2;
      gain_spread += with_opposite * autocovariance * sums.model;
      Matrix2d gradients;
      gradients << 2 * sums.xx, sums.xy, sums.xy, 2 * sums.yy;
      spread += 0.5 * with_opposite * autocovariance * gradients;
    }
  const double degrees = pixels.count / (pixels.count - kParameters);
  spread *= degrees;
  const Eigen::LLT<Matrix2d> solver(normal), positive(spread);
  if (solver.info() != Eigen::Success || positive.info() != Eigen::Success) return std::nullopt;
  const Matrix2d inverse = solver.solve(Matrix2d::Identity());
  MatchPrecision precision;
  precision.covariance = inverse * spread * inverse;
  precision.correlation_without_grain = WithoutGrain(pixels, variance);
  // The sum over few lags may be too small; the value for independent residuals is the lower limit.
  const double model_squares = Sum(pixels.model.square());
  gain_spread = degrees * std::max(gain_spread, variance * model_squares);
  precision.gain_over_sigma = pixels.gain * model_squares / std::sqrt(gain_spread);
  return precision;
}

std::optional<double> CorrelationWithoutGrain(const Image& image, const Image& model,
                                              const Vector2d& model_from_image,
                                              double most_residual) {
  Pixels pixels = Sample(image, model, model_from_image);
  if (pixels.count <= kParameters || !Regress(&pixels)) return std::nullopt;
  const double variance = ResidualVariance(pixels);
  if (variance > most_residual * most_residual) return std::nullopt;
  return WithoutGrain(pixels, variance);
}

}  // namespace orient::interior
