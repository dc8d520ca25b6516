// Rough ground for tests of surfaces, and rays to it.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>

#include "core/terrain/ground_surface.h"

namespace orient {

inline constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

inline Ray From(const Eigen::Vector3d& origin, const Eigen::Vector3d& to) {
  return {origin, (to - origin).normalized()};
}

// Hills, steps and holes: nothing that a smooth approximation could follow.
inline Eigen::MatrixXf RoughGround(int rows, int columns, double holes, std::mt19937* random) {
  std::uniform_real_distribution<float> any(0, 1);
  Eigen::MatrixXf heights(rows, columns);
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      heights(r, c) = 100 + 40 * std::sin(0.3f * static_cast<float>(r)) +
                      30 * std::cos(0.2f * static_cast<float>(c)) + 15 * any(*random);
      if (any(*random) < 0.1f) heights(r, c) += 60;
      if (any(*random) < static_cast<float>(holes)) heights(r, c) = kNone;
    }
  return heights;
}

}  // namespace orient
