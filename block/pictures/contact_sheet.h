// The marks of all photos of a run at a glance.
#pragma once

#include <string>
#include <vector>

#include "core/files/results.h"

namespace orient::block {

// Writes <directory>/contact_sheet.png from the photos' <photo>.marks.png: one row per photo with
// its name and status, its marks side by side, framed green (used), orange (rejected) or red
// (missing). Rows stand in as many columns as a page of about 3600 x 3600 pixels takes; what does
// not fit on the first page goes to contact_sheet_2.png and so on. Pages of an earlier run are
// removed. Returns the paths written. A marks picture that is absent or damaged leaves its row
// grey.
std::vector<std::string> WriteContactSheet(const std::string& directory,
                                           const std::vector<InteriorResult>& results);

}  // namespace orient::block
