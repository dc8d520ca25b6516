#include "interior/match_precision.h"

#include <Eigen/Dense>
#include <cmath>

#include "core/imaging/resample.h"

namespace orient {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kFarthestLag = 3;

struct Pixel {
  bool valid = false;
  double seen = 0, model = 0, residual = 0;
  Vector2d gradient = Vector2d::Zero();
};

struct Pixels {
  int width = 0, height = 0;
  std::vector<Pixel> all;
  int count = 0;

  const Pixel* At(int col, int row) const {
    if (col < 0 || row < 0 || col >= width || row >= height) return nullptr;
    const Pixel& p = all[static_cast<size_t>(row) * width + col];
    return p.valid ? &p : nullptr;
  }
};

Pixels Sample(const Image& image, const Image& model, const Vector2d& model_from_image) {
  Pixels pixels{image.width, image.height, std::vector<Pixel>(image.values.size()), 0};
  for (int row = 0; row < image.height; ++row) {
    for (int col = 0; col < image.width; ++col) {
      Pixel& p = pixels.all[static_cast<size_t>(row) * image.width + col];
      float value = 0;
      Eigen::Vector2f gradient;
      const Vector2d at = Vector2d(col + 0.5, row + 0.5) + model_from_image;
      p.valid = std::isfinite(image.At(col, row)) &&
                SampleBicubicWithGradient(model, at, &value, &gradient);
      if (!p.valid) continue;
      p.seen = static_cast<double>(image.At(col, row));
      p.model = static_cast<double>(value);
      p.gradient = gradient.cast<double>();
      ++pixels.count;
    }
  }
  return pixels;
}

// seen = offset + gain * model + residual; gradients become those of gain * model.
bool Regress(Pixels* pixels) {
  double m = 0, s = 0, mm = 0, ms = 0;
  for (const Pixel& p : pixels->all) {
    if (!p.valid) continue;
    m += p.model;
    s += p.seen;
    mm += p.model * p.model;
    ms += p.model * p.seen;
  }
  const double n = pixels->count, variance = mm - m * m / n;
  if (!(variance > 0)) return false;
  const double gain = (ms - m * s / n) / variance, offset = (s - gain * m) / n;
  for (Pixel& p : pixels->all) {
    p.residual = p.seen - offset - gain * p.model;
    p.gradient *= gain;
  }
  return true;
}

// The part of the right-hand side's covariance that pixels at one distance from another make.
Matrix2d AtLag(const Pixels& pixels, int dc, int dr) {
  Matrix2d gradients = Matrix2d::Zero();
  double products = 0;
  int pairs = 0;
  for (int row = 0; row < pixels.height; ++row) {
    for (int col = 0; col < pixels.width; ++col) {
      const Pixel* a = pixels.At(col, row);
      const Pixel* b = pixels.At(col + dc, row + dr);
      if (a == nullptr || b == nullptr) continue;
      gradients += a->gradient * b->gradient.transpose();
      products += a->residual * b->residual;
      ++pairs;
    }
  }
  if (pairs == 0) return Matrix2d::Zero();
  return products / pairs * 0.5 * (gradients + gradients.transpose());
}

}  // namespace

std::optional<Matrix2d> ShiftCovariance(const Image& image, const Image& model,
                                        const Vector2d& model_from_image) {
  constexpr int kParameters = 4;
  Pixels pixels = Sample(image, model, model_from_image);
  if (pixels.count <= kParameters || !Regress(&pixels)) return std::nullopt;
  Matrix2d normal = Matrix2d::Zero(), spread = Matrix2d::Zero();
  for (const Pixel& p : pixels.all)
    if (p.valid) normal += p.gradient * p.gradient.transpose();
  for (int dr = -kFarthestLag; dr <= kFarthestLag; ++dr)
    for (int dc = -kFarthestLag; dc <= kFarthestLag; ++dc) spread += AtLag(pixels, dc, dr);
  spread *= static_cast<double>(pixels.count) / (pixels.count - kParameters);
  const Eigen::LLT<Matrix2d> solver(normal), positive(spread);
  if (solver.info() != Eigen::Success || positive.info() != Eigen::Success) return std::nullopt;
  const Matrix2d inverse = solver.solve(Matrix2d::Identity());
  return Matrix2d(inverse * spread * inverse);
}

}  // namespace orient
