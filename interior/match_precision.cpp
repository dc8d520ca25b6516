#include "interior/match_precision.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/imaging/resample.h"

namespace orient {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Plane = Eigen::Array<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr int kFarthestLag = 3;

// The matched pixels as planes, zero where a pixel takes no part.
struct Pixels {
  Plane mask, seen, model, residual, gradient_x, gradient_y;
  double count = 0;
};

Pixels Sample(const Image& image, const Image& model, const Vector2d& model_from_image) {
  const Plane zero = Plane::Zero(image.height, image.width);
  Pixels pixels{zero, zero, zero, zero, zero, zero};
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      if (!std::isfinite(image.At(col, row))) continue;
      float value = 0;
      Eigen::Vector2f gradient;
      const Vector2d at = Vector2d(col + 0.5, row + 0.5) + model_from_image;
      if (!SampleBicubicWithGradient(model, at, &value, &gradient)) continue;
      pixels.mask(row, col) = 1;
      pixels.seen(row, col) = image.At(col, row);
      pixels.model(row, col) = value;
      pixels.gradient_x(row, col) = gradient.x();
      pixels.gradient_y(row, col) = gradient.y();
      ++pixels.count;
    }
  }
  return pixels;
}

double Sum(const Plane& a) { return static_cast<double>(a.sum()); }

// seen = offset + gain * model + residual; gradients become those of gain * model.
bool Regress(Pixels* p) {
  const double n = p->count, m = Sum(p->model) / n, s = Sum(p->seen) / n;
  // Around the means, as squares of large grey values lose the digits that count.
  const Plane model = (p->model - static_cast<float>(m)) * p->mask;
  const Plane seen = (p->seen - static_cast<float>(s)) * p->mask;
  const double variance = Sum(model.square());
  if (!(variance > 0)) return false;
  const auto gain = static_cast<float>(Sum(model * seen) / variance);
  p->residual = seen - gain * model;
  p->gradient_x *= gain;
  p->gradient_y *= gain;
  return true;
}

// Sum of products of a plane and another one `dc`, `dr` pixels on; dr >= 0.
double SumAtLag(const Plane& a, const Plane& b, Index dc, Index dr) {
  const Index rows = a.rows() - dr, cols = a.cols() - std::abs(dc);
  if (rows <= 0 || cols <= 0) return 0;
  const Index left = std::max<Index>(0, -dc), right = std::max<Index>(0, dc);
  double sum = 0;
  for (Index r = 0; r < rows; ++r)
    sum += static_cast<double>(
        (a.row(r).segment(left, cols) * b.row(r + dr).segment(right, cols)).sum());
  return sum;
}

// The part of the right-hand side's covariance that pixels at one distance from another make, and
// at the opposite one.
Matrix2d AtLag(const Pixels& p, Index dc, Index dr) {
  const double pairs = SumAtLag(p.mask, p.mask, dc, dr);
  if (pairs < 1) return Matrix2d::Zero();
  const double mixed =
      SumAtLag(p.gradient_x, p.gradient_y, dc, dr) + SumAtLag(p.gradient_y, p.gradient_x, dc, dr);
  Matrix2d gradients;
  gradients << 2 * SumAtLag(p.gradient_x, p.gradient_x, dc, dr), mixed, mixed,
      2 * SumAtLag(p.gradient_y, p.gradient_y, dc, dr);
  const double share = dc == 0 && dr == 0 ? 0.5 : 1.0;  // its own opposite
  return share * SumAtLag(p.residual, p.residual, dc, dr) / pairs * gradients;
}

}  // namespace

std::optional<Matrix2d> ShiftCovariance(const Image& image, const Image& model,
                                        const Vector2d& model_from_image) {
  constexpr int kParameters = 4;
  Pixels pixels = Sample(image, model, model_from_image);
  if (pixels.count <= kParameters || !Regress(&pixels)) return std::nullopt;
  Matrix2d normal, spread = Matrix2d::Zero();
  const double xy = Sum(pixels.gradient_x * pixels.gradient_y);
  normal << Sum(pixels.gradient_x.square()), xy, xy, Sum(pixels.gradient_y.square());
  for (Index dr = 0; dr <= kFarthestLag; ++dr)
    for (Index dc = dr == 0 ? 0 : -kFarthestLag; dc <= kFarthestLag; ++dc)
      spread += AtLag(pixels, dc, dr);
  spread *= pixels.count / (pixels.count - kParameters);
  const Eigen::LLT<Matrix2d> solver(normal), positive(spread);
  if (solver.info() != Eigen::Success || positive.info() != Eigen::Success) return std::nullopt;
  const Matrix2d inverse = solver.solve(Matrix2d::Identity());
  return Matrix2d(inverse * spread * inverse);
}

}  // namespace orient
