// A band-limited texture, known at every position, for tests with exact truth.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "core/raster/image.h"

namespace orient {

// A sum of plane waves with wavelengths of 4 to 40 px; mean 128, standard deviation about 30.
class Texture {
 public:
  explicit Texture(unsigned seed, double shortest_px = 4, int waves = 40) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int i = 0; i < waves; ++i) {
      const double length = shortest_px * std::pow(40 / shortest_px, unit(random));
      const double turn = 2 * std::numbers::pi * unit(random);
      const double frequency = 2 * std::numbers::pi / length;
      waves_.push_back({frequency * std::cos(turn), frequency * std::sin(turn),
                        2 * std::numbers::pi * unit(random)});
    }
  }
  double At(const Eigen::Vector2d& p) const {
    double sum = 0;
    for (const Eigen::Vector3d& wave : waves_)
      sum += std::cos(wave.x() * p.x() + wave.y() * p.y() + wave.z());
    return 128 + 30 * std::sqrt(2.0 / static_cast<double>(waves_.size())) * sum;
  }

 private:
  std::vector<Eigen::Vector3d> waves_;  // frequency x, y (rad/px), phase
};

// Values of a function of position (corner convention) at all pixel centres.
inline Image Draw(int width, int height, const std::function<double(const Eigen::Vector2d&)>& f) {
  Image image(width, height);
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) image.At(c, r) = static_cast<float>(f({c + 0.5, r + 0.5}));
  return image;
}

// Means over pixel areas, from `fine` x `fine` samples each.
inline Image DrawArea(int width, int height, int fine,
                      const std::function<double(const Eigen::Vector2d&)>& f) {
  return Draw(width, height, [&](const Eigen::Vector2d& centre) {
    double sum = 0;
    for (int j = 0; j < fine; ++j)
      for (int i = 0; i < fine; ++i)
        sum += f(centre + Eigen::Vector2d((i + 0.5) / fine - 0.5, (j + 0.5) / fine - 0.5));
    return sum / (fine * fine);
  });
}

inline Image WithNoise(Image image, double sigma, std::mt19937* random) {
  std::normal_distribution<double> noise(0, sigma);
  for (float& value : image.values) value += static_cast<float>(noise(*random));
  return image;
}

inline Image Crop(const Image& image, int col, int row, int width, int height) {
  Image crop(width, height);
  for (int r = 0; r < height; ++r)
    for (int c = 0; c < width; ++c) crop.At(c, r) = image.At(col + c, row + r);
  return crop;
}

}  // namespace orient
