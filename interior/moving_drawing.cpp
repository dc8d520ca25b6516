#include "interior/moving_drawing.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <stdexcept>

namespace orient {
namespace {

using Eigen::Index;
using Eigen::Vector2d;

constexpr Index kBorder = 2;  // of the spline's support
constexpr int kMaxIterations = 12;
constexpr double kConverged = 1e-3;  // px
constexpr double kMinValid = 0.6;    // share of the drawing's pixels that must meet data

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
    : values(image.height, image.width), valid(image.height, image.width) {
  for (size_t i = 0; i < image.values.size(); ++i) {
    const bool finite = std::isfinite(image.values[i]);
    values.data()[i] = finite ? image.values[i] : 0.0f;
    valid.data()[i] = finite ? 1.0f : 0.0f;
  }
}

// The drawing's inner pixels after a move, with its slopes.
struct MovingDrawing::Moved {
  FloatPlane value, slope_x, slope_y;
};

MovingDrawing::MovingDrawing(const FloatPlane& drawing, const FloatPlane& part)
    : coefficients_(drawing), part_(part) {
  if (drawing.rows() != drawing.cols() || drawing.rows() % 2 == 0 ||
      part.rows() != drawing.rows() || part.cols() != drawing.cols() ||
      drawing.rows() <= 2 * kBorder)
    throw std::invalid_argument("MovingDrawing: the drawing is not an odd square");
  Eigen::ArrayXXf lines = drawing;
  ToCoefficients(lines);
  Eigen::ArrayXXf columns = lines.transpose();
  ToCoefficients(columns);
  coefficients_ = columns.transpose();
  const Index inner = drawing.rows() - 2 * kBorder;
  part_ = part.block(kBorder, kBorder, inner, inner).eval();
  part_count_ = static_cast<double>(part_.sum());
}

MovingDrawing::Moved MovingDrawing::MoveBy(const Vector2d& fraction) const {
  const Taps x = TapsAt(fraction.x()), y = TapsAt(fraction.y());
  const Index all = coefficients_.rows(), inner = all - 2 * kBorder;
  FloatPlane value(all, inner), slope(all, inner);
  for (Index r = 0; r < all; ++r) {
    const auto tap = [&](Index k) {
      return coefficients_.row(r).segment(kBorder + x.first + k, inner);
    };
    value.row(r) =
        x.value[0] * tap(0) + x.value[1] * tap(1) + x.value[2] * tap(2) + x.value[3] * tap(3);
    slope.row(r) =
        x.slope[0] * tap(0) + x.slope[1] * tap(1) + x.slope[2] * tap(2) + x.slope[3] * tap(3);
  }
  Moved moved{FloatPlane(inner, inner), FloatPlane(inner, inner), FloatPlane(inner, inner)};
  for (Index r = 0; r < inner; ++r) {
    const Index from = r + kBorder + y.first;
    const auto down = [&](const FloatPlane& plane, const std::array<float, 4>& w) {
      return (w[0] * plane.row(from) + w[1] * plane.row(from + 1) + w[2] * plane.row(from + 2) +
              w[3] * plane.row(from + 3))
          .eval();
    };
    moved.value.row(r) = down(value, y.value);
    moved.slope_x.row(r) = down(slope, y.value);
    moved.slope_y.row(r) = down(value, y.slope);
  }
  return moved;
}

namespace {

// Sums of products over the pixels that take part: ones, drawing, its negative slopes; the image.
struct Sums {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double seen_squares = 0;

  double Count() const { return normal(0, 0); }
  double DrawingSpread() const { return normal(1, 1) - normal(0, 1) * normal(0, 1) / Count(); }
  double SeenSpread() const { return seen_squares - right[0] * right[0] / Count(); }
  double Product() const { return right[1] - normal(0, 1) * right[0] / Count(); }
};

}  // namespace

std::optional<DrawingMatch> MovingDrawing::Match(const SeenPlane& seen, const Vector2d& start,
                                                 double max_shift_px) const {
  const Index inner = part_.rows();
  const double middle = 0.5 * static_cast<double>(inner);
  Vector2d at = start;
  for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
    const Vector2d corner = (at.array() - middle).round();
    const auto col = static_cast<Index>(corner.x()), row = static_cast<Index>(corner.y());
    if (col < 0 || row < 0 || col + inner > seen.values.cols() || row + inner > seen.values.rows())
      return std::nullopt;
    const Moved moved = MoveBy(at - corner - Vector2d::Constant(middle));
    Sums sums;
    using Line = Eigen::Array<float, 1, Eigen::Dynamic>;
    Line weight, value, x, y, image;
    for (Index r = 0; r < inner; ++r) {
      weight = part_.row(r) * seen.valid.row(row + r).segment(col, inner);
      image = seen.values.row(row + r).segment(col, inner) * weight;
      value = moved.value.row(r) * weight;
      x = -moved.slope_x.row(r) * weight;
      y = -moved.slope_y.row(r) * weight;
      const std::array<const Line*, 4> basis = {&weight, &value, &x, &y};
      for (Index i = 0; i < 4; ++i) {
        for (Index j = i; j < 4; ++j)
          sums.normal(i, j) += static_cast<double>((*basis[i] * *basis[j]).sum());
        sums.right[i] += static_cast<double>((*basis[i] * image).sum());
      }
      sums.seen_squares += static_cast<double>(image.square().sum());
    }
    sums.normal.triangularView<Eigen::StrictlyLower>() = sums.normal.transpose();
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
    if (step.norm() < kConverged)
      return DrawingMatch{at, gain,
                          sums.Product() / std::sqrt(sums.DrawingSpread() * sums.SeenSpread())};
  }
  return std::nullopt;
}

}  // namespace orient
