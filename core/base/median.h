// Medians of a few values, and what is made of them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace orient {

// Of an even number of values the greater one of the two in the middle: a value that occurs.
// `values` is not empty.
inline double UpperMedian(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Of an even number of values the mean of the two in the middle. `values` is not empty.
inline double Median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

// The value that a quarter of the others are below: one that occurs. `values` is not empty.
inline double LowerQuartile(std::vector<double> values) {
  const auto quarter = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 4);
  std::nth_element(values.begin(), quarter, values.end());
  return *quarter;
}

// A normal distribution's sigma, as a multiple of the median absolute deviation.
inline constexpr double kSigmaOfMedianDeviation = 1.4826;

struct RobustValue {
  double median = 0;
  double sigma = 0;  // from the median absolute deviation
};

// `values` is not empty.
inline RobustValue Robust(std::vector<double> values) {
  RobustValue robust;
  robust.median = Median(values);
  for (double& value : values) value = std::abs(value - robust.median);
  robust.sigma = kSigmaOfMedianDeviation * Median(std::move(values));
  return robust;
}

}  // namespace orient
