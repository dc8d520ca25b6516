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

// The file's name, not percent-encoded: the photo's, or its number where that is no name of a file
// in this folder (a table may say anything).
std::string PhotoPageFile(const BlockRecord& block, std::size_t photo);

}  // namespace orient
