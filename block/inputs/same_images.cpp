#include "block/inputs/same_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>

#include "block/inputs/digest.h"
#include "core/files/orientation_table.h"

namespace orient::block {

Findings SameImages(const std::vector<std::string>& paths) {
  std::map<std::string, std::vector<std::string>> photos;  // by content
  for (const std::string& path : paths)
    if (const std::string digest = DigestOfFile(path); !digest.empty())
      photos[digest].push_back(PhotoName(path));
  Findings findings;
  for (const auto& [digest, names] : photos)
    if (names.size() > 1)
      findings.push_back({.reason = Reason::kSameImage,
                          .value = static_cast<double>(names.size()),
                          .where = fmt::format("{}", fmt::join(names, ", "))});
  return findings;
}

}  // namespace orient::block
