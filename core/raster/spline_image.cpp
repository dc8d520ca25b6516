#include "core/raster/spline_image.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace orient {
namespace {

constexpr double kPole = -0.26794919243112270647;  // sqrt(3) - 2
// The pole's powers die below double precision.
constexpr int kHorizon = 28;

// In place: samples to spline coefficients, mirrored at both ends.
void ToCoefficients(double* line, int count, int stride) {
  if (count < 2) return;
  const auto at = [line, stride](int i) -> double& {
    return line[static_cast<ptrdiff_t>(i) * stride];
  };
  constexpr double kGain = (1 - kPole) * (1 - 1 / kPole);
  for (int i = 0; i < count; ++i) at(i) *= kGain;
  const auto mirrored = [count](int i) {
    const int period = 2 * count - 2;
    i %= period;
    return i < count ? i : period - i;
  };
  double sum = 0, power = 1;
  for (int i = 0; i < kHorizon; ++i, power *= kPole) sum += power * at(mirrored(i));
  at(0) = sum;
  for (int i = 1; i < count; ++i) at(i) += kPole * at(i - 1);
  at(count - 1) = kPole / (kPole * kPole - 1) * (at(count - 1) + kPole * at(count - 2));
  for (int i = count - 2; i >= 0; --i) at(i) = kPole * (at(i + 1) - at(i));
}

void Weights(double t, std::array<double, 4>* value, std::array<double, 4>* slope) {
  const double s = 1 - t;
  *value = {s * s * s / 6, 2.0 / 3 - t * t * (2 - t) / 2, 2.0 / 3 - s * s * (2 - s) / 2,
            t * t * t / 6};
  *slope = {-s * s / 2, t * (1.5 * t - 2), s * (2 - 1.5 * s), t * t / 2};
}

int Mirrored(int i, int count) {
  if (count == 1) return 0;
  if (i < 0) return -i;
  return i < count ? i : 2 * count - 2 - i;
}

}  // namespace

SplineImage::SplineImage(const Image& image, const PixelWindow& part) {
  col_ = std::clamp(part.col, 0, image.width);
  row_ = std::clamp(part.row, 0, image.height);
  width_ = std::clamp(part.col + part.width, col_, image.width) - col_;
  height_ = std::clamp(part.row + part.height, row_, image.height) - row_;
  coefficients_.resize(static_cast<size_t>(width_) * static_cast<size_t>(height_));
  for (int r = 0; r < height_; ++r)
    std::copy_n(image.Row(row_ + r) + col_, width_, coefficients_.data() + ptrdiff_t{r} * width_);
  if (coefficients_.empty()) return;
  MarkSupport();
  FillGaps();
  for (int r = 0; r < height_; ++r)
    ToCoefficients(coefficients_.data() + ptrdiff_t{r} * width_, width_, 1);
  for (int c = 0; c < width_; ++c) ToCoefficients(coefficients_.data() + c, height_, width_);
}

void SplineImage::MarkSupport() {
  valid_.assign(coefficients_.size(), 1);
  for (int r = 0; r < height_; ++r) {
    for (int c = 0; c < width_; ++c) {
      if (std::isfinite(coefficients_[static_cast<size_t>(r * width_ + c)])) continue;
      for (int i = std::max(0, r - 2); i <= std::min(height_ - 1, r + 1); ++i)
        for (int j = std::max(0, c - 2); j <= std::min(width_ - 1, c + 1); ++j)
          valid_[static_cast<size_t>(i * width_ + j)] = 0;
    }
  }
}

// NaN would spoil its whole row and column of coefficients. Any smooth continuation does: cells
// that see it are not valid.
void SplineImage::FillGaps() {
  const auto fill = [](double* line, int count, int stride) {
    const auto at = [line, stride](int i) -> double& {
      return line[static_cast<ptrdiff_t>(i) * stride];
    };
    for (int i = 1; i < count; ++i)
      if (!std::isfinite(at(i))) at(i) = at(i - 1);
    for (int i = count - 2; i >= 0; --i)
      if (!std::isfinite(at(i))) at(i) = at(i + 1);
  };
  for (int r = 0; r < height_; ++r) fill(coefficients_.data() + ptrdiff_t{r} * width_, width_, 1);
  for (int c = 0; c < width_; ++c) fill(coefficients_.data() + c, height_, width_);
  for (double& value : coefficients_)
    if (!std::isfinite(value)) value = 0;
}

bool SplineImage::Sample(const Eigen::Vector2d& pixel, double* value,
                         Eigen::Vector2d* gradient) const {
  const double x = pixel.x() - 0.5 - col_, y = pixel.y() - 0.5 - row_;
  if (!(x >= 0 && y >= 0 && x <= width_ - 1 && y <= height_ - 1)) return false;
  const int c = std::min(static_cast<int>(x), std::max(0, width_ - 2));
  const int r = std::min(static_cast<int>(y), std::max(0, height_ - 2));
  if (!valid_[static_cast<size_t>(r * width_ + c)]) return false;
  std::array<double, 4> wx, wy, sx, sy;
  Weights(x - c, &wx, &sx);
  Weights(y - r, &wy, &sy);
  std::array<int, 4> cols;
  for (int i = 0; i < 4; ++i) cols[static_cast<size_t>(i)] = Mirrored(c - 1 + i, width_);
  *value = 0;
  gradient->setZero();
  for (size_t j = 0; j < 4; ++j) {
    const double* line =
        coefficients_.data() + ptrdiff_t{Mirrored(r - 1 + static_cast<int>(j), height_)} * width_;
    double sum = 0, slope = 0;
    for (size_t i = 0; i < 4; ++i) {
      sum += wx[i] * line[cols[i]];
      slope += sx[i] * line[cols[i]];
    }
    *value += wy[j] * sum;
    gradient->x() += wy[j] * slope;
    gradient->y() += sy[j] * sum;
  }
  return true;
}

}  // namespace orient
