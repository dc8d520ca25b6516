#include "core/base/binomial.h"

#include <boost/math/distributions/binomial.hpp>
#include <cmath>

namespace orient {

double UpperBoundOfRate(int found, int tried, double probability) {
  if (tried == 0 || found >= tried) return 1;
  return boost::math::binomial_distribution<>::find_upper_bound_on_p(tried, found, probability);
}

double LogTailBound(const std::vector<double>& probabilities, double count) {
  // `bound`: log of exp(-t count) prod(1 + p (exp(t) - 1)); `falls`: it still decreases with t.
  const auto bound = [&](double t) {
    double sum = -t * count;
    for (const double p : probabilities) sum += std::log1p(p * std::expm1(t));
    return sum;
  };
  const auto falls = [&](double t) {
    double expected = 0;
    for (const double p : probabilities) expected += p * std::exp(t) / (1 + p * std::expm1(t));
    return expected < count;
  };
  constexpr double kMost = 60;  // beyond this t every possible event is practically certain
  if (!falls(0)) return 0;
  double low = 0, high = kMost;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (falls(middle) ? low : high) = middle;
  }
  return bound(low);
}

}  // namespace orient
