#include "tools/report/photo_links.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "tools/report/html_text.h"

namespace orient {

std::string PhotoPageFile(const BlockRecord& block, std::size_t photo) {
  constexpr std::size_t kLongest = 200;
  const std::string& name = block.photos[photo].name;
  const bool plain =
      !name.empty() && name.size() < kLongest && name.front() != '.' && name.front() != '#' &&
      name.find('/') == std::string::npos &&
      std::none_of(name.begin(), name.end(), [](unsigned char c) { return std::iscntrl(c) != 0; });
  return (plain ? name : fmt::format("#{}", photo + 1)) + ".html";
}

std::string PhotoLinks::To(const BlockRecord& block, std::size_t photo) const {
  if (!apart) return "#photo-" + std::to_string(photo + 1);
  return std::string(kPhotoPages) + "/" + PercentEncoded(PhotoPageFile(block, photo));
}

}  // namespace orient
