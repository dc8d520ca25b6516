// Numbers in tables and messages.
#pragma once

#include <optional>
#include <string>

namespace orient {

// A number with fixed decimals; "-" where there is none.
std::string Fixed(const std::optional<double>& number, int decimals);

}  // namespace orient
