#include "core/base/date.h"

#include <string_view>

namespace orient {

std::string WhyNoDate(const std::string& date) {
  constexpr std::string_view kShape = "0000-00-00";  // or its first 4 or 7 characters
  const auto has_shape = [&] {
    for (std::size_t i = 0; i < date.size(); ++i)
      if (kShape[i] == '-' ? date[i] != '-' : date[i] < '0' || date[i] > '9') return false;
    return true;
  };
  const auto lies_in = [&](std::size_t at, std::string_view last) {
    return date.size() <= at || (date.substr(at, 2) >= "01" && date.substr(at, 2) <= last);
  };
  const bool known_length = date.size() == 4 || date.size() == 7 || date.size() == 10;
  if (known_length && has_shape() && lies_in(5, "12") && lies_in(8, "31")) return "";
  return date + " is not a date like 1961, 1961-07 or 1961-07-30";
}

}  // namespace orient
