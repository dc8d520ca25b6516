#include "core/base/number_text.h"

#include <fmt/format.h>

#include <cmath>

namespace orient {

std::string Fixed(const std::optional<double>& number, int decimals) {
  return number && std::isfinite(*number) ? fmt::format("{:.{}f}", *number, decimals) : "-";
}

}  // namespace orient
