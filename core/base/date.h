// Dates as people write them who need not know the day.
#pragma once

#include <string>

namespace orient {

// Empty for a year, a month or a day in ISO 8601 (1961, 1961-07, 1961-07-30), otherwise what is
// wrong, for people. Dates are compared as text, so others would compare as anything.
std::string WhyNoDate(const std::string& date);

}  // namespace orient
