// Numbers in sentences and tables.
#pragma once

#include <array>
#include <cstdio>
#include <string>

namespace orient {

// As std::snprintf, up to 400 characters.
template <typename... Values>
std::string FormatText(const char* format, Values... values) {
  std::array<char, 400> text;
  std::snprintf(text.data(), text.size(), format, values...);
  return text.data();
}

}  // namespace orient
