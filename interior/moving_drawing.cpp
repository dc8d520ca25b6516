#include "interior/moving_drawing.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <stdexcept>

namespace orient {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr Index kBorder = 2;   // of the spline's support
constexpr Index kAtATime = 4;  // pixels
using Pixels = Eigen::Array<float, kAtATime, 1>;
constexpr int kMaxIterations = 12;
constexpr double kMinValid = 0.6;  // share of the drawing's pixels that must meet data

// In place: samples to coefficients of the interpolating cubic spline (Unser 1999), zero beyond.
void ToCoefficients(Eigen::Ref<Eigen::ArrayXXf> lines) {  // one signal a column of `lines`
  constexpr auto kPole = -0.26794919243112270647f;
  constexpr float kGain = (1 - kPole) * (1 - 1 / kPole);
  lines *= kGain;
  for (Index i = 1; i < lines.cols(); ++i) lines.col(i) += kPole * lines.col(i - 1);
  const Index last = lines.cols() - 1;
  lines.col(last) *= -kPole / (1 - kPole * kPole);
  for (Index i = last - 1; i >= 0; --i) lines.col(i) = kPole * (lines.col(i + 1) - lines.col(i));
}

// Four taps from pixel `first` on (relative to the pixel looked at).
struct Taps {
  Index first = 0;
  std::array<float, 4> value{}, slope{};
};

// Of the spline at -fraction from a pixel; fraction in [-0.5, 0.5].
Taps TapsAt(double fraction) {
  Taps taps;
  taps.first = fraction > 0 ? -2 : -1;
  const auto t = static_cast<float>(fraction > 0 ? 1 - fraction : -fraction);
  const float s = 1 - t;
  taps.value = {s * s * s / 6, 2.0f / 3 - t * t * (2 - t) / 2, 2.0f / 3 - s * s * (2 - s) / 2,
                t * t * t / 6};
  taps.slope = {-s * s / 2, t * (1.5f * t - 2), s * (2 - 1.5f * s), t * t / 2};
  return taps;
}

inline Eigen::Map<const Pixels> PixelsAt(const float* first) {
  return Eigen::Map<const Pixels>(first);
}

// Four taps, each once for every pixel at a time: in registers, where a reference to the taps would
// be read anew after every store.
struct WideTaps {
  explicit WideTaps(const std::array<float, 4>& w)
      : a(Pixels::Constant(w[0])),
        b(Pixels::Constant(w[1])),
        c(Pixels::Constant(w[2])),
        d(Pixels::Constant(w[3])) {}

  // Of pixels that lie `stride` apart.
  [[gnu::always_inline]] Pixels Sum(const float* first, Index stride) const {
    return a * PixelsAt(first) + b * PixelsAt(first + stride) + c * PixelsAt(first + 2 * stride) +
           d * PixelsAt(first + 3 * stride);
  }

  Pixels a, b, c, d;
};

// out[i] for `count` pixels, at least kAtATime of them.
void AlongRow(const float* from, const std::array<float, 4>& taps, Index count, float* out) {
  const WideTaps wide(taps);
  for (Index i = 0; i < count; i += kAtATime) {
    const Index at = std::min(i, count - kAtATime);  // the last ones, some of them once more
    Eigen::Map<Pixels>(out + at) = wide.Sum(from + at, 1);
  }
}

}  // namespace

SeenPlane::SeenPlane(const Image& image)
    : width(image.width),
      height(image.height),
      values(FloatPlane::Zero(height, width + kAtATime)),
      valid(values) {
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      if (!std::isfinite(image.At(col, row))) continue;
      values(row, col) = image.At(col, row);
      valid(row, col) = 1;
    }
  }
}

// Sums of products over the pixels that take part: ones, drawing, its negative slopes; the image.
struct MovingDrawing::Sums {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double seen_squares = 0;

  double Count() const { return normal(0, 0); }
  double DrawingSpread() const { return normal(1, 1) - normal(0, 1) * normal(0, 1) / Count(); }
  double SeenSpread() const { return seen_squares - right[0] * right[0] / Count(); }
  double Product() const { return right[1] - normal(0, 1) * right[0] / Count(); }
};

DrawingPart::DrawingPart(const FloatPlane& part)
    : inner_(part.rows() - 2 * kBorder),
      cols_(std::max<Index>(inner_, 0), 0),
      weight_(FloatPlane::Zero(std::max<Index>(inner_, 0), std::max<Index>(inner_, 0) + kAtATime)) {
  if (part.rows() != part.cols() || part.rows() % 2 == 0 || inner_ <= 0)
    throw std::invalid_argument("DrawingPart: not an odd square");
  weight_.leftCols(inner_) = part.block(kBorder, kBorder, inner_, inner_);
  count_ = static_cast<double>(weight_.sum());
  for (Index row = 0; row < inner_; ++row) {
    Index first = 0, stop = inner_;
    while (first < stop && weight_(row, first) == 0) ++first;
    while (stop > first && weight_(row, stop - 1) == 0) --stop;
    spans_.emplace_back(first, stop);
    if (first == stop) continue;
    cols_ = {std::min(cols_.first, first), std::max(cols_.second, stop + kAtATime - 1)};
  }
}

MovingDrawing::MovingDrawing(const FloatPlane& drawing, std::shared_ptr<const DrawingPart> part)
    : part_(std::move(part)) {
  const Index side = part_->inner_ + 2 * kBorder;
  if (drawing.rows() != side || drawing.cols() != side)
    throw std::invalid_argument("MovingDrawing: the drawing is not as large as its part");
  Eigen::ArrayXXf lines = drawing;
  ToCoefficients(lines);
  Eigen::ArrayXXf columns = lines.transpose();
  ToCoefficients(columns);
  coefficients_ = FloatPlane::Zero(side, side + kAtATime);
  coefficients_.leftCols(side) = columns.transpose();
}

MovingDrawing::MovingDrawing(FloatPlane coefficients, const MovingDrawing& like)
    : coefficients_(std::move(coefficients)), part_(like.part_) {}

MovingDrawing MovingDrawing::Blurred(double sigma_px) const {
  const auto reach = static_cast<Index>(std::ceil(4 * sigma_px));
  Eigen::ArrayXf weights(2 * reach + 1);
  for (Index i = -reach; i <= reach; ++i)
    weights[i + reach] =
        static_cast<float>(std::exp(-0.5 * static_cast<double>(i * i) / (sigma_px * sigma_px)));
  FloatPlane blurred = SeparableSums(coefficients_, weights / weights.sum());
  blurred.rightCols(kAtATime) = 0;
  return {std::move(blurred), *this};
}

MovingDrawing::Sums MovingDrawing::SumUp(const SeenPlane& seen, Index col, Index row,
                                         const Vector2d& fraction, Across* across) const {
  const Taps x = TapsAt(fraction.x()), y = TapsAt(fraction.y());
  const Index cols = part_->inner_ + kAtATime - 1;
  across->value.resize(coefficients_.rows(), cols);
  across->slope.resize(coefficients_.rows(), cols);
  const auto [left, right_end] = part_->cols_;
  const WideTaps down(y.value), down_slope(y.slope);
  Sums sums;
  Index ready = 0;  // rows of `across`
  for (Index r = 0; r < part_->inner_; ++r) {
    const auto [first, stop] = part_->spans_[static_cast<size_t>(r)];
    if (first == stop) continue;
    const Index from = r + kBorder + y.first;
    for (ready = std::max(ready, from); ready < from + 4; ++ready) {
      const float* taken = &coefficients_(ready, left + kBorder + x.first);
      AlongRow(taken, x.value, right_end - left, &across->value(ready, left));
      AlongRow(taken, x.slope, right_end - left, &across->slope(ready, left));
    }
    Pixels n = Pixels::Zero(), d = n, u = n, v = n, dd = n, du = n, dv = n, uu = n, uv = n, vv = n,
           s = n, sd = n, su = n, sv = n, ss = n;
    const float* values = across->value.data() + from * cols;
    const float* slopes = across->slope.data() + from * cols;
    const float* weights = part_->weight_.data() + r * part_->weight_.cols();
    const float* valid = seen.valid.data() + (row + r) * seen.valid.cols() + col;
    const float* grey = seen.values.data() + (row + r) * seen.values.cols() + col;
    for (Index c = first; c < stop; c += kAtATime) {
      const Pixels weight = PixelsAt(weights + c) * PixelsAt(valid + c);
      const Pixels drawn = down.Sum(values + c, cols) * weight;
      const Pixels right = -down.Sum(slopes + c, cols) * weight;
      const Pixels below = -down_slope.Sum(values + c, cols) * weight;
      const Pixels image = PixelsAt(grey + c) * weight;
      n += weight, d += drawn, u += right, v += below, s += image;
      dd += drawn * drawn, du += drawn * right, dv += drawn * below;
      uu += right * right, uv += right * below, vv += below * below;
      sd += image * drawn, su += image * right, sv += image * below, ss += image * image;
    }
    const auto sum = [](const Pixels& pixels) { return static_cast<double>(pixels.sum()); };
    Eigen::Matrix4d normal;
    normal << sum(n), sum(d), sum(u), sum(v), 0, sum(dd), sum(du), sum(dv), 0, 0, sum(uu), sum(uv),
        0, 0, 0, sum(vv);
    sums.normal += normal;
    sums.right += Eigen::Vector4d(sum(s), sum(sd), sum(su), sum(sv));
    sums.seen_squares += sum(ss);
  }
  sums.normal.triangularView<Eigen::StrictlyLower>() = sums.normal.transpose();
  return sums;
}

std::optional<DrawingMatch> MovingDrawing::Match(const SeenPlane& seen, const Vector2d& start,
                                                 double max_shift_px, double converged_px) const {
  const Index inner = part_->inner_;
  const double middle = 0.5 * static_cast<double>(inner);
  Vector2d at = start;
  Across across;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Vector2d corner = (at.array() - middle).round();
    const auto col = static_cast<Index>(corner.x()), row = static_cast<Index>(corner.y());
    if (col < 0 || row < 0 || col + inner > seen.width || row + inner > seen.height)
      return std::nullopt;
    const Sums sums = SumUp(seen, col, row, at - corner - Vector2d::Constant(middle), &across);
    if (sums.Count() < std::max(8.0, kMinValid * part_->count_) || !(sums.DrawingSpread() > 0) ||
        !(sums.SeenSpread() > 0))
      return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix4d> solver(sums.normal);
    const Eigen::Vector4d solved = solver.solve(sums.right);
    const double gain = solved[1];
    if (solver.info() != Eigen::Success || !solved.allFinite() || !(gain > 0)) return std::nullopt;
    Vector2d step(solved[2] / gain, solved[3] / gain);
    constexpr double kLongestStep = 2;
    if (step.norm() > kLongestStep) step *= kLongestStep / step.norm();
    at += step;
    if ((at - start).norm() > max_shift_px) return std::nullopt;
    if (step.norm() < converged_px)
      return DrawingMatch{at, gain,
                          sums.Product() / std::sqrt(sums.DrawingSpread() * sums.SeenSpread())};
  }
  return std::nullopt;
}

}  // namespace orient
