// Deterministic randomness of the simulator: hashes, smooth noise over the plane, and a stream of
// random numbers. The same on every machine, unlike the standard library's distributions.
#pragma once

#include <cmath>
#include <cstdint>

namespace orient::simulation {

// An avalanche mix of 32 bits (Wellons' "lowbias32" constants).
inline std::uint32_t Mix(std::uint32_t x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  return x ^ (x >> 16);
}

inline std::uint32_t Hash(std::uint32_t seed, std::int32_t a, std::int32_t b = 0) {
  return Mix(seed ^ Mix(static_cast<std::uint32_t>(a) * 0x9e3779b9u +
                        static_cast<std::uint32_t>(b) * 0x85ebca6bu));
}

// [0, 1) from a hash.
inline float Unit(std::uint32_t hash) { return static_cast<float>(hash >> 8) * 0x1p-24f; }

// std::floor without the library call, for |x| < 2^31.
inline std::int32_t FloorInt(float x) {
  const auto i = static_cast<std::int32_t>(x);
  return i - (x < static_cast<float>(i) ? 1 : 0);
}

// 0 below `low`, 1 above `high`, smooth between.
inline float SmoothStep(float low, float high, float x) {
  const float t = std::fmin(1.0f, std::fmax(0.0f, (x - low) / (high - low)));
  return t * t * (3 - 2 * t);
}

// Smooth noise in [-1, 1] with one random value at every integer point.
float ValueNoise(std::uint32_t seed, float x, float y);

// `octaves` layers of ValueNoise, each half the wavelength and half the amplitude; about [-1, 1].
float FractalNoise(std::uint32_t seed, float x, float y, int octaves);

// A stream of random numbers (SplitMix64).
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : state_(seed) {}
  std::uint64_t Next();
  double Uniform();                         // [0, 1)
  double Uniform(double low, double high);  // [low, high)
  double Gaussian();                        // mean 0, sigma 1
  bool Chance(double probability) { return Uniform() < probability; }

 private:
  std::uint64_t state_;
};

}  // namespace orient::simulation
