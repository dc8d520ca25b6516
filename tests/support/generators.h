// RapidCheck generators shared by the geometry tests.
#pragma once

#include <rapidcheck.h>

#include <Eigen/Core>

namespace orient {

// Uniform in [low, high].
inline rc::Gen<double> InRange(double low, double high) {
  constexpr int kSteps = 1 << 24;
  return rc::gen::map(rc::gen::resize(100, rc::gen::inRange(0, kSteps + 1)), [low, high](int i) {
    return low + (high - low) * i / static_cast<double>(kSteps);
  });
}

}  // namespace orient
