#include "core/geometry/sigma.h"

#include <fmt/format.h>

namespace orient {

std::string SigmaProblem(double sigma) {
  constexpr double kLeast = 1e-9, kMost = 1e6;
  if (sigma >= kLeast && sigma <= kMost) return "";
  return fmt::format("it must lie between {:g} and {:.0f}", kLeast, kMost);
}

}  // namespace orient
