#include "tools/simulate/scanner.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "tools/simulate/noise.h"

namespace orient::simulation {
namespace {

std::vector<float> GaussianKernel(double sigma_px) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3.5 * sigma_px)));
  std::vector<float> kernel;
  float sum = 0;
  for (int i = -radius; i <= radius; ++i) {
    kernel.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma_px * sigma_px))));
    sum += kernel.back();
  }
  for (float& weight : kernel) weight /= sum;
  return kernel;
}

// Grain of unit sigma, a little wider than a pixel: the mean of four neighbouring random values.
float Grain(std::uint32_t seed, int col, int row) {
  const float sum = Unit(Hash(seed, col, row)) + Unit(Hash(seed, col + 1, row)) +
                    Unit(Hash(seed, col, row + 1)) + Unit(Hash(seed, col + 1, row + 1));
  return (sum - 2) * std::sqrt(3.0f);  // the sum of four has the variance 4 / 12
}

}  // namespace

void Blur(double sigma_px, Image* image) {
  if (sigma_px <= 0) return;
  const std::vector<float> kernel = GaussianKernel(sigma_px);
  const int radius = static_cast<int>(kernel.size() / 2);
  const int width = image->width, height = image->height;
  Image across(width, height);
  tbb::parallel_for(0, height, [&](int row) {
    for (int col = 0; col < width; ++col) {
      float sum = 0;
      for (int k = -radius; k <= radius; ++k)
        sum += kernel[static_cast<size_t>(k + radius)] *
               image->At(std::clamp(col + k, 0, width - 1), row);
      across.At(col, row) = sum;
    }
  });
  tbb::parallel_for(0, height, [&](int row) {
    float* out = image->Row(row);
    std::fill(out, out + width, 0.0f);
    for (int k = -radius; k <= radius; ++k) {
      const float* in = across.Row(std::clamp(row + k, 0, height - 1));
      const float weight = kernel[static_cast<size_t>(k + radius)];
      for (int col = 0; col < width; ++col) out[col] += weight * in[col];
    }
  });
}

std::vector<std::uint16_t> Scan(const Image& positive, const ScannerOptions& options) {
  std::vector<std::uint16_t> grey(positive.values.size());
  const float largest = options.bits == 16 ? 65535.0f : 255.0f;
  const auto grain = static_cast<float>(options.grain / 255.0);
  tbb::parallel_for(0, positive.height, [&](int row) {
    const float* in = positive.Row(row);
    std::uint16_t* out =
        grey.data() + static_cast<size_t>(row) * static_cast<size_t>(positive.width);
    for (int col = 0; col < positive.width; ++col) {
      float value = options.negative ? 1 - in[col] : in[col];
      if (grain > 0) value += grain * Grain(options.seed, col, row);
      out[col] = static_cast<std::uint16_t>(std::clamp(value * largest + 0.5f, 0.0f, largest));
    }
  });
  return grey;
}

}  // namespace orient::simulation
