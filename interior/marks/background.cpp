#include "interior/marks/background.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <tuple>
#include <utility>
#include <vector>

#include "core/matching/float_sums.h"

namespace orient::interior {
namespace {

constexpr float kRounding = 4e-6f;

// Sums over blocks of pixels, and how many of a block's pixels are data.
struct Blocks {
  FloatPlane sum, count;
};

std::pair<float, float> SumOfData(const float* values, int pixels) {
  float sum = 0, count = 0;
  for (int i = 0; i < pixels; ++i) {
    if (!std::isfinite(values[i])) continue;
    sum += values[i];
    ++count;
  }
  return {sum, count};
}

Blocks SumBlocks(const Image& image, int side) {
  const int cols = (image.width + side - 1) / side, rows = (image.height + side - 1) / side;
  Blocks blocks{FloatPlane::Zero(rows, cols), FloatPlane::Zero(rows, cols)};
  for (int row = 0; row < image.height; ++row) {
    const float* values = image.Row(row);
    for (int b = 0; b < cols; ++b) {
      const int pixels = std::min(side, image.width - b * side);
      float sum = Eigen::Map<const Eigen::ArrayXf>(values + b * side, pixels).sum();
      float count = static_cast<float>(pixels);
      if (!std::isfinite(sum)) std::tie(sum, count) = SumOfData(values + b * side, pixels);
      blocks.sum.coeffRef(row / side, b) += sum;
      blocks.count.coeffRef(row / side, b) += count;
    }
  }
  return blocks;
}

Eigen::ArrayXf GaussianWeights(double sigma) {
  const int reach = std::max(1, static_cast<int>(std::ceil(4 * sigma)));
  Eigen::ArrayXf weights(2 * reach + 1);
  for (int i = -reach; i <= reach; ++i)
    weights[i + reach] = static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)));
  return weights;
}

// Where a pixel's centre lies between the centres of blocks.
struct Between {
  Eigen::Index low = 0, high = 0;
  float part = 0;  // of the high one
};

std::vector<Between> Places(int pixels, int side, Eigen::Index blocks) {
  std::vector<Between> places;
  for (int i = 0; i < pixels; ++i) {
    const double at = std::clamp((i + 0.5) / side - 0.5, 0.0, static_cast<double>(blocks - 1));
    const auto low = static_cast<Eigen::Index>(at);
    places.push_back({low, std::min(low + 1, blocks - 1), static_cast<float>(at - std::floor(at))});
  }
  return places;
}

}  // namespace

Image RemoveBackground(const Image& image, double sigma_px) {
  if (!(sigma_px > 0)) throw std::invalid_argument("RemoveBackground: sigma is not positive");
  if (image.Empty()) return image;
  const int side = std::max(1, static_cast<int>(std::lround(sigma_px / 3)));
  // Averaging over blocks and interpolating between them blur by themselves: 1/12 + 1/6 of side^2.
  const double own = side > 1 ? 0.25 : 0.0;
  const auto weights =
      GaussianWeights(std::sqrt(std::max(sigma_px * sigma_px / (side * side) - own, 0.1)));
  const Blocks blocks = SumBlocks(image, side);
  // Zeros beyond the border; the count, convolved alike, makes up for it.
  const FloatPlane sum = SeparableSums(blocks.sum, weights);
  const FloatPlane count = SeparableSums(blocks.count, weights);
  const FloatPlane mean = (count > 0).select(sum / count.max(1e-20f), 0.0f);
  // Between the blocks of a row of blocks first, then between the rows.
  const auto cols = Places(image.width, side, mean.cols());
  const auto rows = Places(image.height, side, mean.rows());
  FloatPlane wide(mean.rows(), image.width);
  for (Eigen::Index row = 0; row < mean.rows(); ++row)
    for (int col = 0; col < image.width; ++col) {
      const Between& h = cols[static_cast<size_t>(col)];
      wide(row, col) = (1 - h.part) * mean(row, h.low) + h.part * mean(row, h.high);
    }
  Image result = image;
  using Line = Eigen::Array<float, 1, Eigen::Dynamic>;
  Line blended(image.width), rounding(image.width), rest(image.width);
  for (int row = 0; row < image.height; ++row) {
    const Between& v = rows[static_cast<size_t>(row)];
    blended = (1 - v.part) * wide.row(v.low) + v.part * wide.row(v.high);
    Eigen::Map<Line> values(result.Row(row), image.width);
    // Rounding is not texture: flat film stays flat. Larger values shrink by as much, so that
    // the result is continuous.
    rounding = kRounding * blended.abs();
    rest = values - blended;
    values = rest - rest.max(-rounding).min(rounding);
  }
  return result;
}

}  // namespace orient::interior
