// Limits of tests whose statistic is chi-square distributed.
#pragma once

namespace orient {

// The value that chi-square with `degrees_of_freedom` exceeds with this probability: 27.86 for six
// and 1e-4, 11.83 for two and 0.0027 (three sigma). Throws std::invalid_argument for fewer than one
// degree of freedom and for probabilities outside (0, 1).
double ChiSquareLimit(int degrees_of_freedom, double probability);

// CE90 and LE90 as multiples of a coordinate's sigma: the roots of chi-square's limits for two and
// one degrees of freedom at 0.1, as NSSDA rounds them.
inline constexpr double kCircularError90 = 2.1460, kLinearError90 = 1.6449;

}  // namespace orient
