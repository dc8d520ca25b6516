// What each reason is called in files, and how it is told to people. Private to core/files.
#pragma once

#include <string_view>
#include <vector>

#include "core/files/reason.h"

namespace orient {

// A sentence with the places {value}, {limit} and {where} of a Finding, formatted as fmt does.
struct Wording {
  Reason reason;
  std::string_view code;
  std::string_view sentence;
};

const std::vector<Wording>& Wordings();

}  // namespace orient
