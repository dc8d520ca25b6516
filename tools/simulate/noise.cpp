#include "tools/simulate/noise.h"

#include <numbers>

namespace orient::simulation {

float ValueNoise(std::uint32_t seed, float x, float y) {
  const std::int32_t i = FloorInt(x), j = FloorInt(y);
  const float fx = x - static_cast<float>(i), fy = y - static_cast<float>(j);
  // Quintic fade: no visible lattice in the noise's derivatives.
  const float u = fx * fx * fx * (fx * (fx * 6 - 15) + 10);
  const float v = fy * fy * fy * (fy * (fy * 6 - 15) + 10);
  const float a = Unit(Hash(seed, i, j)), b = Unit(Hash(seed, i + 1, j));
  const float c = Unit(Hash(seed, i, j + 1)), d = Unit(Hash(seed, i + 1, j + 1));
  const float top = a + u * (b - a), bottom = c + u * (d - c);
  return 2 * (top + v * (bottom - top)) - 1;
}

float FractalNoise(std::uint32_t seed, float x, float y, int octaves) {
  float sum = 0, amplitude = 1, total = 0;
  for (int octave = 0; octave < octaves; ++octave) {
    // Each octave turned a little, so that the lattices do not line up.
    sum += amplitude * ValueNoise(seed + static_cast<std::uint32_t>(octave) * 7919u, x, y);
    total += amplitude;
    const float turned = 1.6f * x - 1.2f * y;
    y = 1.2f * x + 1.6f * y;
    x = turned;
    amplitude *= 0.5f;
  }
  return total > 0 ? sum / total : 0;
}

std::uint64_t RandomStream::Next() {
  std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
  return z ^ (z >> 31);
}

double RandomStream::Uniform() { return static_cast<double>(Next() >> 11) * 0x1p-53; }

double RandomStream::Uniform(double low, double high) { return low + (high - low) * Uniform(); }

double RandomStream::Gaussian() {
  const double radius = std::sqrt(-2 * std::log(1 - Uniform()));
  return radius * std::cos(2 * std::numbers::pi * Uniform());
}

}  // namespace orient::simulation
