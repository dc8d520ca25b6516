// The formats that `orient convert` reads and writes.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace orient {

enum class ExchangeFormat {
  kOpk,
  kOri,
  kPatb,
  kBingo,
  kMicmac,
  kMetashape,
  kColmap,
  kOpensfm,
  kAsp
};
inline constexpr std::array<ExchangeFormat, 9> kAllExchangeFormats = {
    ExchangeFormat::kOpk,    ExchangeFormat::kOri,     ExchangeFormat::kPatb,
    ExchangeFormat::kBingo,  ExchangeFormat::kMicmac,  ExchangeFormat::kMetashape,
    ExchangeFormat::kColmap, ExchangeFormat::kOpensfm, ExchangeFormat::kAsp};

std::string Name(ExchangeFormat format);  // "opk" ... "asp"
std::optional<ExchangeFormat> ExchangeFormatFromName(const std::string& name);

}  // namespace orient
