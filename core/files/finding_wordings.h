// What each reason is called in files, and how it is told to people. Private to core/files.
#pragma once

#include <string_view>
#include <vector>

#include "core/files/reason.h"

namespace orient {

// A sentence with places for what a Finding has, formatted as fmt does: {value}, {limit}, {where};
// {first} and {rest} of a where that is "first: rest"; and of as many things as {value} says {s}
// (of the plural), {are}, {their} and {They_have}.
struct Wording {
  Reason reason;
  std::string_view code;
  std::string_view sentence;
};

const std::vector<Wording>& Wordings();

}  // namespace orient
