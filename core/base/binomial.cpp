#include "core/base/binomial.h"

#include <boost/math/distributions/binomial.hpp>

namespace orient {

double UpperBoundOfRate(int found, int tried, double probability) {
  if (tried == 0 || found >= tried) return 1;
  return boost::math::binomial_distribution<>::find_upper_bound_on_p(tried, found, probability);
}

}  // namespace orient
