// What a measurement's standard deviation may be.
#pragma once

#include <string>

namespace orient {

// Why `sigma` (pixels, mm, m or degrees) is not a valid standard deviation; empty if it is. With
// values outside the valid range, weights would no longer be finite numbers.
std::string SigmaProblem(double sigma);

}  // namespace orient
