// Dates as people write them, possibly without the month or the day.
#pragma once

#include <string>

namespace orient {

// Empty for a year, a month or a day in ISO 8601 (1961, 1961-07, 1961-07-30), otherwise what is
// wrong, in words. Dates are compared as text, so any other format would compare wrongly.
std::string DateProblem(const std::string& date);

}  // namespace orient
