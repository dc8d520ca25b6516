// Numbers in tables, files and messages.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

namespace orient {

// A number with fixed decimals; "-" where there is none.
std::string Fixed(const std::optional<double>& number, int decimals);

// The finite number that the whole text is, in no locale's way; nothing where it is none. A point
// is the decimal mark; "+1", " 1" and "" are none.
template <typename Number = double>
std::optional<Number> NumberIn(std::string_view text) {
  Number number{};
  const char* last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, number);
  if (error != std::errc() || end != last) return std::nullopt;
  if constexpr (std::is_floating_point_v<Number>)
    if (!std::isfinite(number)) return std::nullopt;
  return number;
}

// The same; one plus sign may stand before it.
inline std::optional<double> SignedNumberIn(std::string_view text) {
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  return NumberIn(plus ? text.substr(1) : text);
}

}  // namespace orient
