// Where the parts of a report stand: all on one page, or each photo, and long lists, on their own.
#pragma once

#include <string>

#include "tools/report/block_record.h"

namespace orient {

// Folder of the photos' pages, below the report's own.
inline constexpr const char* kPhotoPages = "report_photos";

struct PhotoLinks {
  bool apart = false;

  // From report.html to the photo (its index in the block).
  std::string To(const BlockRecord& block, std::size_t photo) const;
};

// The file's name, not percent-encoded.
std::string PhotoPageFile(const PhotoRecord& photo);

}  // namespace orient
