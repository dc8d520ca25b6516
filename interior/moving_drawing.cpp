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

MovingDrawing::MovingDrawing(const FloatPlane& drawing, const FloatPlane& part)
    : inner_(drawing.rows() - 2 * kBorder) {
  if (drawing.rows() != drawing.cols() || drawing.rows() % 2 == 0 ||
      part.rows() != drawing.rows() || part.cols() != drawing.cols() || inner_ <= 0)
    throw std::invalid_argument("MovingDrawing: the drawing is not an odd square");
  Eigen::ArrayXXf lines = drawing;
  ToCoefficients(lines);
  Eigen::ArrayXXf columns = lines.transpose();
  ToCoefficients(columns);
  coefficients_ = FloatPlane::Zero(drawing.rows(), drawing.cols() + kAtATime);
  coefficients_.leftCols(drawing.cols()) = columns.transpose();
  part_ = FloatPlane::Zero(inner_, inner_ + kAtATime);
  part_.leftCols(inner_) = part.block(kBorder, kBorder, inner_, inner_);
  part_count_ = static_cast<double>(part_.sum());
  for (Index row = 0; row < inner_; ++row) {
    Index first = 0, stop = inner_;
    while (first < stop && part_(row, first) == 0) ++first;
    while (stop > first && part_(row, stop - 1) == 0) --stop;
    spans_.emplace_back(first, stop);
  }
}

MovingDrawing::Sums MovingDrawing::SumUp(const SeenPlane& seen, Index col, Index row,
                                         const Vector2d& fraction, Across* across) const {
  const Taps x = TapsAt(fraction.x()), y = TapsAt(fraction.y());
  const Index cols = inner_ + kAtATime - 1;
  FloatPlane &value = across->value, &slope = across->slope;
  value.resize(coefficients_.rows(), cols);
  slope.resize(coefficients_.rows(), cols);
  for (Index r = 0; r < coefficients_.rows(); ++r) {
    const auto tap = [&](Index k) {
      return coefficients_.row(r).segment(kBorder + x.first + k, cols);
    };
    value.row(r) =
        x.value[0] * tap(0) + x.value[1] * tap(1) + x.value[2] * tap(2) + x.value[3] * tap(3);
    slope.row(r) =
        x.slope[0] * tap(0) + x.slope[1] * tap(1) + x.slope[2] * tap(2) + x.slope[3] * tap(3);
  }
  Sums sums;
  for (Index r = 0; r < inner_; ++r) {
    const Index from = r + kBorder + y.first;
    const auto [first, stop] = spans_[static_cast<size_t>(r)];
    Pixels n = Pixels::Zero(), d = n, u = n, v = n, dd = n, du = n, dv = n, uu = n, uv = n, vv = n,
           s = n, sd = n, su = n, sv = n, ss = n;
    for (Index c = first; c < stop; c += kAtATime) {
      const auto at = [c](const FloatPlane& plane, Index line) {
        return Eigen::Map<const Pixels>(&plane(line, c));
      };
      const auto down = [&](const FloatPlane& plane, const std::array<float, 4>& w) {
        return Pixels(w[0] * at(plane, from) + w[1] * at(plane, from + 1) +
                      w[2] * at(plane, from + 2) + w[3] * at(plane, from + 3));
      };
      const Pixels weight = at(part_, r) * Eigen::Map<const Pixels>(&seen.valid(row + r, col + c));
      const Pixels drawn = down(value, y.value) * weight;
      const Pixels right = -down(slope, y.value) * weight, below = -down(value, y.slope) * weight;
      const Pixels image = Eigen::Map<const Pixels>(&seen.values(row + r, col + c)) * weight;
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
  const double middle = 0.5 * static_cast<double>(inner_);
  Vector2d at = start;
  Across across;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Vector2d corner = (at.array() - middle).round();
    const auto col = static_cast<Index>(corner.x()), row = static_cast<Index>(corner.y());
    if (col < 0 || row < 0 || col + inner_ > seen.width || row + inner_ > seen.height)
      return std::nullopt;
    const Sums sums = SumUp(seen, col, row, at - corner - Vector2d::Constant(middle), &across);
    if (sums.Count() < std::max(8.0, kMinValid * part_count_) || !(sums.DrawingSpread() > 0) ||
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
