#include "core/raster/spline_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace orient {
namespace {

constexpr double kPole = -0.26794919243112270647;  // sqrt(3) - 2
// Higher powers of the pole are below double precision.
constexpr int kHorizon = 28;
constexpr double kFar = 1e8;  // pixels: no image reaches so far

// Weights of the four coefficients around a place between the second and the third.
struct Weights {
  std::array<double, 4> value, slope;

  explicit Weights(double t) {
    const double s = 1 - t;
    value = {s * s * s / 6, 2.0 / 3 - t * t * (2 - t) / 2, 2.0 / 3 - s * s * (2 - s) / 2,
             t * t * t / 6};
    slope = {-s * s / 2, t * (1.5 * t - 2), s * (2 - 1.5 * s), t * t / 2};
  }
};

// Sum of four neighbouring blocks.
template <typename Block>
auto Weighted(const std::array<double, 4>& weights, const Block& block) {
  return weights[0] * block(0) + weights[1] * block(1) + weights[2] * block(2) +
         weights[3] * block(3);
}

int Mirrored(int i, int count) {
  if (count == 1) return 0;
  const int folded = std::abs(i) % (2 * count - 2);
  return folded < count ? folded : 2 * count - 2 - folded;
}

}  // namespace

SplineImage::SplineImage(const Image& image, const PixelWindow& part) {
  col_ = std::clamp(part.col, 0, image.width);
  row_ = std::clamp(part.row, 0, image.height);
  width_ = std::clamp(part.col + part.width, col_, image.width) - col_;
  height_ = std::clamp(part.row + part.height, row_, image.height) - row_;
  if (width_ == 0 || height_ == 0) {
    width_ = height_ = 0;
    return;
  }
  coefficients_.resize(height_, width_);
  for (int r = 0; r < height_; ++r)
    coefficients_.row(r) = Eigen::Map<const Eigen::ArrayXf>(image.Row(row_ + r) + col_, width_)
                               .cast<double>()
                               .transpose();
  valid_ = Grid::Ones(height_, width_);
  if (!coefficients_.allFinite()) {
    MarkSupport(coefficients_);
    FillGaps(&coefficients_);
  }
  FilterDown(&coefficients_);
  Grid turned = coefficients_.transpose();
  FilterDown(&turned);
  coefficients_ = turned.transpose();
}

// In place: columns of samples to spline coefficients, mirrored at both ends.
void SplineImage::FilterDown(Grid* samples) {
  const Eigen::Index count = samples->rows();
  if (count < 2) return;
  constexpr double kGain = (1 - kPole) * (1 - 1 / kPole);
  *samples *= kGain;
  Eigen::Array<double, 1, Eigen::Dynamic> first = samples->row(0);
  double power = kPole;
  for (Eigen::Index i = 1; i < kHorizon; ++i, power *= kPole) {
    first += power * samples->row(Mirrored(static_cast<int>(i), static_cast<int>(count)));
  }
  samples->row(0) = first;
  for (Eigen::Index i = 1; i < count; ++i) samples->row(i) += kPole * samples->row(i - 1);
  samples->row(count - 1) =
      kPole / (kPole * kPole - 1) * (samples->row(count - 1) + kPole * samples->row(count - 2));
  for (Eigen::Index i = count - 2; i >= 0; --i)
    samples->row(i) = kPole * (samples->row(i + 1) - samples->row(i));
}

void SplineImage::MarkSupport(const Grid& samples) {
  for (int r = 0; r < height_; ++r)
    for (int c = 0; c < width_; ++c) {
      if (std::isfinite(samples(r, c))) continue;
      const int top = std::max(0, r - 2), left = std::max(0, c - 2);
      valid_
          .block(top, left, std::min(height_ - 1, r + 1) - top + 1,
                 std::min(width_ - 1, c + 1) - left + 1)
          .setZero();
    }
}

// NaN would spoil its whole row and column of coefficients. Any smooth continuation does: cells
// that depend on it are not valid.
void SplineImage::FillGaps(Grid* samples) {
  const auto fill = [](auto&& line) {
    for (Eigen::Index i = 1; i < line.size(); ++i)
      if (!std::isfinite(line[i])) line[i] = line[i - 1];
    for (Eigen::Index i = line.size() - 2; i >= 0; --i)
      if (!std::isfinite(line[i])) line[i] = line[i + 1];
  };
  for (Eigen::Index r = 0; r < samples->rows(); ++r) fill(samples->row(r));
  for (Eigen::Index c = 0; c < samples->cols(); ++c) fill(samples->col(c));
  *samples = samples->isFinite().select(*samples, 0);
}

bool SplineImage::Sample(const Eigen::Vector2d& pixel, double* value,
                         Eigen::Vector2d* gradient) const {
  const double x = pixel.x() - 0.5 - col_, y = pixel.y() - 0.5 - row_;
  if (!(x >= 0 && y >= 0 && x <= width_ - 1 && y <= height_ - 1)) return false;
  const int c = std::min(static_cast<int>(x), std::max(0, width_ - 2));
  const int r = std::min(static_cast<int>(y), std::max(0, height_ - 2));
  if (valid_(r, c) == 0) return false;
  const Weights across(x - c), down(y - r);
  std::array<int, 4> cols;
  for (int i = 0; i < 4; ++i) cols[static_cast<size_t>(i)] = Mirrored(c - 1 + i, width_);
  *value = 0;
  gradient->setZero();
  for (size_t j = 0; j < 4; ++j) {
    const double* line =
        coefficients_.data() + ptrdiff_t{Mirrored(r - 1 + static_cast<int>(j), height_)} * width_;
    double sum = 0, slope = 0;
    for (size_t i = 0; i < 4; ++i) {
      sum += across.value[i] * line[cols[i]];
      slope += across.slope[i] * line[cols[i]];
    }
    *value += down.value[j] * sum;
    gradient->x() += down.value[j] * slope;
    gradient->y() += down.slope[j] * sum;
  }
  return true;
}

SplineSamples SplineImage::SampleGrid(const Eigen::Vector2d& first, int cols, int rows) const {
  const Eigen::Index count = Eigen::Index{cols} * rows;
  SplineSamples samples{Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count),
                        Eigen::ArrayXd::Zero(count), Eigen::ArrayXd::Zero(count)};
  const double x = first.x() - 0.5 - col_, y = first.y() - 0.5 - row_;
  if (!(std::abs(x) < kFar && std::abs(y) < kFar) || coefficients_.size() == 0) return samples;
  const int c = static_cast<int>(std::floor(x)), r = static_cast<int>(std::floor(y));
  // All that lie between the part's pixel centres.
  const int left = std::max(0, -c), right = std::min(cols, width_ - c - (x > c ? 1 : 0));
  const int top = std::max(0, -r), bottom = std::min(rows, height_ - r - (y > r ? 1 : 0));
  const int width = right - left, height = bottom - top;
  if (width <= 0 || height <= 0) return samples;

  Grid around(height + 3, width + 3);
  for (int i = 0; i < height + 3; ++i) {
    const int row = Mirrored(r + top - 1 + i, height_);
    for (int k = 0; k < width + 3; ++k)
      around(i, k) = coefficients_(row, Mirrored(c + left - 1 + k, width_));
  }
  const Weights across(x - c), down(y - r);
  const auto beside = [&](int k) { return around.middleCols(k, width); };
  const Grid sum = Weighted(across.value, beside), slope = Weighted(across.slope, beside);
  const auto inside = [&](Eigen::ArrayXd* all) {
    return Eigen::Map<Grid>(all->data(), rows, cols).block(top, left, height, width);
  };
  const Grid valid = valid_.block(r + top, c + left, height, width);
  const auto sum_below = [&](int k) { return sum.middleRows(k, height); };
  const auto slope_below = [&](int k) { return slope.middleRows(k, height); };
  inside(&samples.value) = valid * Weighted(down.value, sum_below);
  inside(&samples.by_col) = valid * Weighted(down.value, slope_below);
  inside(&samples.by_row) = valid * Weighted(down.slope, sum_below);
  inside(&samples.known) = valid;
  return samples;
}

}  // namespace orient
