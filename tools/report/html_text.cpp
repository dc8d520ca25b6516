#include "tools/report/html_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "core/base/number_text.h"

namespace orient {
namespace {

constexpr const char* kReplacement = "\xEF\xBF\xBD";
constexpr const char* kMinus = "\xE2\x88\x92";

bool IsTrail(unsigned char byte) { return (byte & 0xC0) == 0x80; }

// Bytes of the UTF-8 character at `i` that XML allows; 0 where there is none.
size_t CharacterLength(std::string_view text, size_t i) {
  const auto lead = static_cast<unsigned char>(text[i]);
  if (lead < 0x80) return lead >= 0x20 || lead == '\t' || lead == '\n' ? 1 : 0;
  const size_t length = lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
  if (lead < 0xC2 || lead > 0xF4 || i + length > text.size()) return 0;
  std::uint32_t code = lead & (0x7Fu >> length);
  for (size_t k = 1; k < length; ++k) {
    const auto trail = static_cast<unsigned char>(text[i + k]);
    if (!IsTrail(trail)) return 0;
    code = (code << 6) | (trail & 0x3Fu);
  }
  const bool overlong = (length == 3 && code < 0x800) || (length == 4 && code < 0x10000);
  const bool surrogate = code >= 0xD800 && code <= 0xDFFF;
  const bool forbidden = code == 0xFFFE || code == 0xFFFF || code < 0xA0;  // C1 controls
  return overlong || surrogate || forbidden || code > 0x10FFFF ? 0 : length;
}

std::string Printed(double number, int decimals) {
  std::string text = Fixed(number, decimals);
  if (text.starts_with('-') && text.find_first_of("123456789") == std::string::npos)
    text.erase(0, 1);  // a rounded zero has no sign
  return text;
}

}  // namespace

std::string ValidText(std::string_view text) {
  std::string valid;
  valid.reserve(text.size());
  for (size_t i = 0; i < text.size();) {
    const size_t length = CharacterLength(text, i);
    if (length == 0)
      valid += kReplacement;
    else
      valid += text.substr(i, length);
    i += length == 0 ? 1 : length;
  }
  return valid;
}

std::string Escape(std::string_view text) {
  std::string escaped;
  escaped.reserve(text.size());
  for (const char c : ValidText(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\'':
        escaped += "&#39;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string Decimal(double number, int decimals) {
  if (!std::isfinite(number)) return kNoValue;
  const std::string text = Printed(number, decimals);
  return text.starts_with('-') ? kMinus + text.substr(1) : text;
}

std::string Decimal(const std::optional<double>& number, int decimals) {
  return number ? Decimal(*number, decimals) : kNoValue;
}

std::string Decimals(const Eigen::Vector3d& numbers, int decimals) {
  return fmt::format("{} / {} / {}", Decimal(numbers.x(), decimals), Decimal(numbers.y(), decimals),
                     Decimal(numbers.z(), decimals));
}

std::string Grouped(double number, int decimals) {
  if (!std::isfinite(number)) return kNoValue;
  const std::string text = Printed(std::abs(number), decimals);
  const size_t whole = std::min(text.find('.'), text.size());
  std::string grouped =
      number < 0 && text.find_first_of("123456789") != std::string::npos ? kMinus : "";
  for (size_t i = 0; i < whole; ++i) {
    if (i > 0 && (whole - i) % 3 == 0) grouped += kThinSpace;
    grouped += text[i];
  }
  return grouped + text.substr(whole);
}

int DecimalsForSigma(double sigma) {
  if (!(sigma > 0) || !std::isfinite(sigma)) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9);
}

std::string SvgNumber(double number, int decimals) {
  std::string text = Printed(std::isfinite(number) ? number : 0.0, decimals);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.ends_with('.')) text.pop_back();
  return text;
}

std::string Joined(const std::vector<std::string>& texts, std::string_view between) {
  return fmt::format("{}", fmt::join(texts, between));
}

std::string PercentEncoded(std::string_view file_name) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  std::string encoded = "./";  // so that "a:b.png" is a file and not a scheme
  for (const char c : file_name) {
    if (kPlain.find(c) != std::string_view::npos) {
      encoded += c;
      continue;
    }
    constexpr std::string_view kHex = "0123456789ABCDEF";
    const auto byte = static_cast<unsigned char>(c);
    encoded += {'%', kHex[byte >> 4], kHex[byte & 15u]};
  }
  return encoded;
}

std::string PercentEncodedPath(std::string_view path) {
  std::string encoded = ".";
  for (std::size_t begin = 0;;) {
    const std::size_t end = path.find('/', begin);
    encoded += PercentEncoded(path.substr(begin, end - begin)).substr(1);
    if (end == std::string_view::npos) return encoded;
    begin = end + 1;
  }
}

}  // namespace orient
