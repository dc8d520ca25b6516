#include "interior/marks/moving_drawing.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

namespace orient::interior {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr Index kBorder = 2;   // of the spline's support
constexpr Index kAtATime = 4;  // pixels
using Pixels = Eigen::Array<float, kAtATime, 1>;
constexpr int kPlainIterations = 12, kScaledIterations = 12;
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

inline Eigen::Map<const Pixels> PixelsAt(const float* first) {
  return Eigen::Map<const Pixels>(first);
}

// Taps, each repeated for all pixels processed at a time: in registers, as a reference would be
// read again after every store.
template <int kTaps>
struct WideTaps {
  explicit WideTaps(const std::array<float, 5>& taps) {
    for (size_t i = 0; i < kTaps; ++i) tap[i] = Pixels::Constant(taps[i]);
  }

  // Of pixels that lie `stride` apart.
  [[gnu::always_inline]] Pixels Sum(const float* first, Index stride) const {
    Pixels sum = tap[0] * PixelsAt(first);
    for (int i = 1; i < kTaps; ++i)
      sum += tap[static_cast<size_t>(i)] * PixelsAt(first + i * stride);
    return sum;
  }
  // Of pixels at several places.
  [[gnu::always_inline]] Pixels Sum(const std::array<const float*, 5>& from, Index at) const {
    Pixels sum = tap[0] * PixelsAt(from[0] + at);
    for (size_t i = 1; i < kTaps; ++i) sum += tap[i] * PixelsAt(from[i] + at);
    return sum;
  }

  std::array<Pixels, kTaps> tap;
};

// Sums of the products of some pixels' values.
struct Products {
  Pixels n = Pixels::Zero(), d = n, u = n, v = n, dd = n, du = n, dv = n, uu = n, uv = n, vv = n,
         s = n, sd = n, su = n, sv = n, ss = n;

  // Of the drawing, its negative slopes and the image, all of them times their weight.
  [[gnu::always_inline]] void Add(const Pixels& weight, const Pixels& drawn, const Pixels& right,
                                  const Pixels& below, const Pixels& image) {
    n += weight, d += drawn, u += right, v += below, s += image;
    dd += drawn * drawn, du += drawn * right, dv += drawn * below;
    uu += right * right, uv += right * below, vv += below * below;
    sd += image * drawn, su += image * right, sv += image * below, ss += image * image;
  }
};

// Factor of a computed step that leads to where no step remains, if steps keep changing as
// they did over the last movement (secant).
double ScaleOf(const Vector2d& step, const Vector2d& last_step, const Vector2d& moved) {
  constexpr double kLeast = 0.5, kMost = 4;  // of the step's decrease per unit of movement
  const double covers = (last_step - step).dot(moved) / moved.squaredNorm();
  return 1 / std::clamp(covers, kLeast, kMost);
}

double Total(const Pixels& pixels) { return static_cast<double>(pixels.sum()); }

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

  void Add(const Products& p) {
    Eigen::Matrix4d upper;
    upper << Total(p.n), Total(p.d), Total(p.u), Total(p.v), 0, Total(p.dd), Total(p.du),
        Total(p.dv), 0, 0, Total(p.uu), Total(p.uv), 0, 0, 0, Total(p.vv);
    normal += upper;
    right += Eigen::Vector4d(Total(p.s), Total(p.sd), Total(p.su), Total(p.sv));
    seen_squares += Total(p.ss);
  }

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

SharpDrawing::SharpDrawing(const FloatPlane& drawing, int finer,
                           std::shared_ptr<const DrawingPart> part)
    : finer_(finer), part_(std::move(part)) {
  const Index side = finer * (part_->inner_ + 2 * kBorder);
  if (finer < 1 || finer > 2 || drawing.rows() != side || drawing.cols() != side)
    throw std::invalid_argument("SharpDrawing: the drawing is not as large as its part");
  Eigen::ArrayXXf lines = drawing;
  ToCoefficients(lines);
  Eigen::ArrayXXf columns = lines.transpose();
  ToCoefficients(columns);
  coefficients_ = columns.transpose();
}

MovingDrawing SharpDrawing::Blurred(double sigma_px) const {
  const double sigma = finer_ * sigma_px;
  const auto reach = static_cast<Index>(std::ceil(4 * sigma));
  Eigen::ArrayXf weights(2 * reach + 1);
  for (Index i = -reach; i <= reach; ++i)
    weights[i + reach] =
        static_cast<float>(std::exp(-0.5 * static_cast<double>(i * i) / (sigma * sigma)));
  return {SeparableSums(coefficients_, weights / weights.sum()), finer_, part_};
}

MovingDrawing::MovingDrawing(const FloatPlane& coefficients, int finer,
                             std::shared_ptr<const DrawingPart> part)
    : finer_(finer),
      width_(coefficients.cols() / finer + kAtATime),
      planes_(FloatPlane::Zero(coefficients.rows(), finer * width_)),
      part_(std::move(part)) {
  for (Index row = 0; row < coefficients.rows(); ++row)
    for (Index plane = 0; plane < finer; ++plane) {
      const float* from = &coefficients(row, plane);
      float* to = &planes_(row, plane * width_);
      for (Index col = 0; col < width_ - kAtATime; ++col) to[col] = from[finer * col];
    }
}

// From pixel `first` of the drawing on (relative to the first one of the image's pixel): `finer` +
// 3 taps, for the value and its slope in the image's pixels.
struct MovingDrawing::Taps {
  Index first = 0;
  std::array<float, 5> value{}, slope{};
};

// Taps of the spline at -fraction from a pixel; fraction in [-0.5, 0.5].
MovingDrawing::Taps MovingDrawing::TapsAt(double fraction) const {
  const double shift = finer_ * fraction, whole = std::round(shift), rest = shift - whole;
  const auto t = static_cast<float>(rest > 0 ? 1 - rest : -rest);
  const float s = 1 - t;
  const std::array<float, 4> value = {s * s * s / 6, 2.0f / 3 - t * t * (2 - t) / 2,
                                      2.0f / 3 - s * s * (2 - s) / 2, t * t * t / 6};
  const std::array<float, 4> slope = {-s * s / 2, t * (1.5f * t - 2), s * (2 - 1.5f * s),
                                      t * t / 2};
  Taps taps;
  taps.first = (rest > 0 ? -2 : -1) - static_cast<Index>(whole);
  const auto count = static_cast<size_t>(finer_);
  for (size_t pixel = 0; pixel < count; ++pixel)
    for (size_t i = 0; i < 4; ++i) {
      taps.value[pixel + i] += value[i] / static_cast<float>(finer_);
      taps.slope[pixel + i] += slope[i];
    }
  return taps;
}

MovingDrawing::Across MovingDrawing::Memory() const {
  Across across;
  across.value.resize(planes_.rows(), part_->inner_ + kAtATime - 1);
  across.slope.resize(planes_.rows(), part_->inner_ + kAtATime - 1);
  return across;
}

template <int kTaps>
Index MovingDrawing::MoveAcross(const Taps& x, const Taps& y, Index row,
                                std::pair<Index, Index> cols, Across* across) const {
  const Index first = finer_ * (row + kBorder) + y.first;
  const WideTaps<kTaps> value(x.value), slope(x.slope);
  const auto [left, stop] = cols;
  for (across->ready = std::max(across->ready, first); across->ready < first + kTaps;
       ++across->ready) {
    std::array<const float*, 5> from{};
    for (Index i = 0; i < kTaps; ++i) {
      const Index col = finer_ * kBorder + x.first + i;
      from[static_cast<size_t>(i)] = &planes_(across->ready, col % finer_ * width_ + col / finer_);
    }
    float* values = &across->value(across->ready, 0);
    float* slopes = &across->slope(across->ready, 0);
    for (Index c = left; c < stop; c += kAtATime) {
      const Index at = std::min(c, stop - kAtATime);  // the last group overlaps the one before
      Eigen::Map<Pixels>(values + at) = value.Sum(from, at);
      Eigen::Map<Pixels>(slopes + at) = slope.Sum(from, at);
    }
  }
  return first;
}

template <int kTaps>
MovingDrawing::Sums MovingDrawing::SumUp(const SeenPlane& seen, Index col, Index row,
                                         const Vector2d& fraction, Across* across) const {
  const Taps x = TapsAt(fraction.x()), y = TapsAt(fraction.y());
  const WideTaps<kTaps> down(y.value), down_slope(y.slope);
  const Index cols = across->value.cols();
  across->ready = 0;
  Sums sums;
  for (Index r = 0; r < part_->inner_; ++r) {
    const auto [first, stop] = part_->spans_[static_cast<size_t>(r)];
    if (first == stop) continue;
    const Index from = MoveAcross<kTaps>(x, y, r, part_->cols_, across);
    const float* values = &across->value(from, 0);
    const float* slopes = &across->slope(from, 0);
    const float* weights = &part_->weight_(r, 0);
    const float* valid = &seen.valid(row + r, col);
    const float* grey = &seen.values(row + r, col);
    Products products;
    for (Index c = first; c < stop; c += kAtATime) {
      const Pixels weight = PixelsAt(weights + c) * PixelsAt(valid + c);
      products.Add(weight, down.Sum(values + c, cols) * weight,
                   -down.Sum(slopes + c, cols) * weight, -down_slope.Sum(values + c, cols) * weight,
                   PixelsAt(grey + c) * weight);
    }
    sums.Add(products);
  }
  sums.normal.triangularView<Eigen::StrictlyLower>() = sums.normal.transpose();
  return sums;
}

template <int kTaps>
Image MovingDrawing::MovedBy(const Vector2d& fraction) const {
  const Index inner = part_->inner_;
  const Taps x = TapsAt(fraction.x()), y = TapsAt(fraction.y());
  const WideTaps<kTaps> down(y.value);
  Across across = Memory();
  const auto side = static_cast<int>(inner + 2 * kBorder);
  Image moved(side, side, kNoData);
  Eigen::ArrayXf line =
      Eigen::ArrayXf::Zero(inner + kAtATime);  // the last pixels reach beyond the row
  for (Index r = 0; r < inner; ++r) {
    const Index from = MoveAcross<kTaps>(x, y, r, {0, across.value.cols()}, &across);
    for (Index c = 0; c < inner; c += kAtATime)
      line.segment<kAtATime>(c) = down.Sum(&across.value(from, c), across.value.cols());
    std::copy_n(line.data(), inner, moved.Row(static_cast<int>(r + kBorder)) + kBorder);
  }
  return moved;
}

Image MovingDrawing::Moved(const Vector2d& fraction) const {
  return finer_ == 1 ? MovedBy<4>(fraction) : MovedBy<5>(fraction);
}

std::optional<DrawingMatch> MovingDrawing::Match(const SeenPlane& seen, const Vector2d& start,
                                                 double max_shift_px, double converged_px,
                                                 Steps steps) const {
  const Index inner = part_->inner_;
  const double middle = 0.5 * static_cast<double>(inner);
  Vector2d at = start, last_step = Vector2d::Zero(), moved = Vector2d::Zero();
  Across across = Memory();
  const int iterations = kPlainIterations + (steps == Steps::kScaled ? kScaledIterations : 0);
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Vector2d corner = (at.array() - middle).round();
    const auto col = static_cast<Index>(corner.x()), row = static_cast<Index>(corner.y());
    if (col < 0 || row < 0 || col + inner > seen.width || row + inner > seen.height)
      return std::nullopt;
    const Vector2d fraction = at - corner - Vector2d::Constant(middle);
    const Sums sums = finer_ == 1 ? SumUp<4>(seen, col, row, fraction, &across)
                                  : SumUp<5>(seen, col, row, fraction, &across);
    if (sums.Count() < std::max(8.0, kMinValid * part_->count_) || !(sums.DrawingSpread() > 0) ||
        !(sums.SeenSpread() > 0))
      return std::nullopt;
    const Eigen::LDLT<Eigen::Matrix4d> solver(sums.normal);
    const Eigen::Vector4d solved = solver.solve(sums.right);
    const double gain = solved[1];
    if (solver.info() != Eigen::Success || !solved.allFinite() || !(gain > 0)) return std::nullopt;
    const Vector2d step(solved[2] / gain, solved[3] / gain);
    // If it still moves in one direction, nothing similar to the drawing is near.
    if (iteration == kPlainIterations && step.dot(moved) > 0) return std::nullopt;
    const double scale = iteration < kPlainIterations ? 1 : ScaleOf(step, last_step, moved);
    constexpr double kLongestStep = 2;
    moved = step * std::min(scale, kLongestStep / step.norm());
    last_step = step;
    at += moved;
    if ((at - start).norm() > max_shift_px) return std::nullopt;
    if (step.norm() < converged_px)
      return DrawingMatch{at, gain,
                          sums.Product() / std::sqrt(sums.DrawingSpread() * sums.SeenSpread())};
  }
  return std::nullopt;
}

}  // namespace orient::interior
