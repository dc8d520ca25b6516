#include "core/base/chi_square.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <stdexcept>

namespace orient {

double ChiSquareLimit(int degrees_of_freedom, double probability) {
  if (degrees_of_freedom < 1 || !(probability > 0 && probability < 1))
    throw std::invalid_argument("ChiSquareLimit: no such distribution or probability");
  const boost::math::chi_squared distribution(degrees_of_freedom);
  return boost::math::quantile(boost::math::complement(distribution, probability));
}

}  // namespace orient
