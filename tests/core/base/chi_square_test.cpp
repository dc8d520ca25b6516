#include "core/base/chi_square.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace orient {
namespace {

TEST(ChiSquareLimit, OfTwoDegreesOfFreedomIsALogarithm) {
  for (const double probability : {0.5, 0.0027, 1e-9})
    EXPECT_NEAR(ChiSquareLimit(2, probability), -2 * std::log(probability), 1e-9);
}

TEST(ChiSquareLimit, IsThatOfTheTables) {  // Abramowitz & Stegun, table 26.8
  EXPECT_NEAR(ChiSquareLimit(1, 0.05), 3.84146, 1e-5);
  EXPECT_NEAR(ChiSquareLimit(3, 0.5), 2.36597, 1e-5);
  EXPECT_NEAR(ChiSquareLimit(6, 1e-4), 27.8563, 1e-4);
}

TEST(ChiSquareLimit, OfNothingIsRefused) {
  EXPECT_THROW(ChiSquareLimit(0, 0.5), std::invalid_argument);
  EXPECT_THROW(ChiSquareLimit(2, 0), std::invalid_argument);
  EXPECT_THROW(ChiSquareLimit(2, 1), std::invalid_argument);
}

}  // namespace
}  // namespace orient
