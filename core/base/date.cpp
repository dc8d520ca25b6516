#include "core/base/date.h"

#include <charconv>
#include <chrono>
#include <string_view>

namespace orient {

std::string DateProblem(const std::string& date) {
  constexpr std::string_view kShape = "0000-00-00";  // or its first 4 or 7 characters
  const auto has_shape = [&] {
    for (std::size_t i = 0; i < date.size(); ++i)
      if (kShape[i] == '-' ? date[i] != '-' : date[i] < '0' || date[i] > '9') return false;
    return true;
  };
  const auto number = [&](std::size_t at, std::size_t digits, int otherwise) {
    if (date.size() > at) std::from_chars(&date[at], &date[at] + digits, otherwise);
    return otherwise;
  };
  const auto exists = [&] {
    return (std::chrono::year(number(0, 4, 0)) / number(5, 2, 1) / number(8, 2, 1)).ok();
  };
  const bool known_length = date.size() == 4 || date.size() == 7 || date.size() == 10;
  if (known_length && has_shape() && exists()) return "";
  return date + " is not a date like 1961, 1961-07 or 1961-07-30";
}

}  // namespace orient
