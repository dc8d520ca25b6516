// The report's style sheet: light, for a laptop and for paper.
#pragma once

#include <string_view>

namespace orient {

extern const std::string_view kReportStyle;

}  // namespace orient
