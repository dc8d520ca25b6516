#include "core/files/flight_plan.h"

#include <algorithm>
#include <cctype>

namespace orient {
namespace {

bool IsDigit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

// The run of digits or the single character that begins at `at`; digits without leading zeros.
std::string PieceAt(const std::string& text, std::size_t* at) {
  const std::size_t begin = *at;
  if (!IsDigit(text[begin])) return text.substr((*at)++, 1);
  while (*at < text.size() && IsDigit(text[*at])) ++*at;
  const std::string digits = text.substr(begin, *at - begin);
  return digits.substr(std::min(digits.find_first_not_of('0'), digits.size() - 1));
}

}  // namespace

bool NaturallyLess(const std::string& a, const std::string& b) {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    const bool numbers = IsDigit(a[i]) && IsDigit(b[j]);
    const std::string piece_a = PieceAt(a, &i), piece_b = PieceAt(b, &j);
    if (numbers && piece_a.size() != piece_b.size()) return piece_a.size() < piece_b.size();
    if (piece_a != piece_b) return piece_a < piece_b;
  }
  if (i < a.size() || j < b.size()) return j < b.size();
  return a < b;  // "01" and "1"
}

}  // namespace orient
