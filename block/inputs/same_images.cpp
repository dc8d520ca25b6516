#include "block/inputs/same_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

namespace orient::block {

Findings SameImages(const std::vector<BlockPhotoFile>& photos) {
  std::map<std::string, std::vector<std::string>> names_of;  // by content
  for (const BlockPhotoFile& photo : photos)
    if (const auto scan = photo.exterior.made_from.find("scan");
        scan != photo.exterior.made_from.end() && !scan->second.empty())
      names_of[scan->second].push_back(photo.name);
  Findings findings;
  for (const auto& [digest, names] : names_of)
    if (names.size() > 1)
      findings.push_back({.reason = Reason::kSameImage,
                          .value = static_cast<double>(names.size()),
                          .where = fmt::format("{}", fmt::join(names, ", "))});
  return findings;
}

}  // namespace orient::block
