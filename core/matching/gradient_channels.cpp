#include "core/matching/gradient_channels.h"

#include <algorithm>
#include <cmath>

#include "core/matching/correlation_sums.h"
#include "core/raster/resample.h"

namespace orient {
namespace {

using Eigen::Index;

constexpr double kDerivativeSigma_px = 0.8;  // of the Gaussian before the gradient
constexpr double kSmoothingSigma_px = 0.6;   // of the channels
// Of the Gaussian that averages the strength around a pixel, by which its channels are divided.
constexpr double kStrengthSigma_px = 2.0;
constexpr double kFloor = 0.2;  // added to that strength, in units of its mean over the image

// The gradient's strength, and strength times cosine and sine of twice its direction.
struct DoubledAngle {
  Image strength, cosine, sine;

  explicit DoubledAngle(const Image& image)
      : strength(image.width, image.height, kNoData), cosine(strength), sine(strength) {
    for (int row = 1; row + 1 < image.height; ++row)
      for (int col = 1; col + 1 < image.width; ++col) Fill(image, col, row);
  }

  void Fill(const Image& image, int col, int row) {
    const float gx = (image.At(col + 1, row) - image.At(col - 1, row)) / 2;
    const float gy = (image.At(col, row + 1) - image.At(col, row - 1)) / 2;
    if (!std::isfinite(gx) || !std::isfinite(gy) || !std::isfinite(image.At(col, row))) return;
    const float length = std::sqrt(gx * gx + gy * gy);
    const float unit = length > 0 ? 1 / length : 0.0F;
    strength.At(col, row) = length;
    cosine.At(col, row) = (gx * gx - gy * gy) * unit;
    sine.At(col, row) = 2 * gx * gy * unit;
  }
};

float MeanOf(const Image& image) {
  double sum = 0, count = 0;
  for (const float v : image.values)
    if (std::isfinite(v)) sum += double(v), ++count;
  return count > 0 ? static_cast<float>(sum / count) : 0.0F;
}

Image Divided(Image channel, const Image& by, float floor) {
  for (std::size_t i = 0; i < channel.values.size(); ++i) {
    const float strength = by.values[i] + floor;
    if (strength > 0) channel.values[i] /= strength;
  }
  return channel;
}

}  // namespace

GradientChannels ChannelsOf(const Image& image) {
  const DoubledAngle gradients(GaussianBlur(image, kDerivativeSigma_px));
  const Image around = GaussianBlur(gradients.strength, kStrengthSigma_px);
  const float floor = static_cast<float>(kFloor) * MeanOf(gradients.strength);
  const double sigma = kSmoothingSigma_px;
  return {{Divided(GaussianBlur(gradients.cosine, sigma), around, floor),
           Divided(GaussianBlur(gradients.sine, sigma), around, floor)}};
}

namespace {

// Zero where there is no data.
Plane PlaneOf(const Image& image) {
  Plane plane(image.height, image.width);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    plane.data()[i] = std::isfinite(image.values[i]) ? double(image.values[i]) : 0;
  return plane;
}

// One where there is data.
Plane MaskOf(const Image& image) {
  Plane plane(image.height, image.width);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    plane.data()[i] = std::isfinite(image.values[i]) ? 1 : 0;
  return plane;
}

}  // namespace

Image CorrelateChannels(const GradientChannels& templ, const GradientChannels& image,
                        double min_valid) {
  const Eigen::Vector2i templ_size(templ.Width(), templ.Height());
  const Eigen::Vector2i image_size(image.Width(), image.Height());
  if (templ_size.x() < 1 || (templ_size.array() > image_size.array()).any()) return {};
  const Plane tc = PlaneOf(templ.channels[0]), ts = PlaneOf(templ.channels[1]);
  const Plane ic = PlaneOf(image.channels[0]), is = PlaneOf(image.channels[1]);
  SpatialSums in_space;
  FftSums by_fft(templ_size, image_size);
  const bool spatial = SpatialCost(templ_size, image_size) <= FftCost(templ_size, image_size);
  ProductSums& by = spatial ? static_cast<ProductSums&>(in_space) : by_fft;
  const Plane product = by.Sum(tc, ic) + by.Sum(ts, is);

  const Plane templ_mask = MaskOf(templ.channels[0]);
  const std::vector<MaskRun> runs = RunsOf(templ.channels[0]);
  const auto over_template = [&](const Plane& plane) {
    return RunSums(plane, templ_mask.rows(), templ_mask.cols(), runs);
  };
  const Plane squares = ic.square() + is.square();
  const Plane energy = over_template(squares);
  const Plane count = over_template(MaskOf(image.channels[0]));
  const double of_templ = tc.square().sum() + ts.square().sum();
  const double needed = std::max(2.0, min_valid * templ_mask.sum()) - 0.5;
  // In windows with less energy than this, rounding dominates.
  const double least = 1e-9 * squares.sum();
  Image result(image_size.x() - templ_size.x() + 1, image_size.y() - templ_size.y() + 1, kNoData);
  for (Index row = 0; row < product.rows(); ++row)
    for (Index col = 0; col < product.cols(); ++col) {
      if (count(row, col) < needed || !(energy(row, col) > least) || !(of_templ > 0)) continue;
      const double score = product(row, col) / std::sqrt(energy(row, col) * of_templ);
      result.At(static_cast<int>(col), static_cast<int>(row)) =
          static_cast<float>(std::clamp(score, -1.0, 1.0));
    }
  return result;
}

}  // namespace orient
