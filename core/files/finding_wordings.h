// Each reason's code in files and its sentence for people. Private to core/files.
#pragma once

#include <string_view>
#include <vector>

#include "core/files/reason.h"

namespace orient {

// A sentence in fmt's format with placeholders for a Finding's fields: {value}, {limit}, {where};
// {first} and {rest} if where is "first: rest"; and, singular or plural as {value} requires, {s},
// {are}, {their} and {They_have}.
struct Wording {
  Reason reason;
  std::string_view code;
  std::string_view sentence;
};

const std::vector<Wording>& Wordings();

}  // namespace orient
