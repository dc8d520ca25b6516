// report.html: what a person looks at to decide whether to trust a block.
#pragma once

#include <string>

#include "tools/report/verdict.h"

namespace orient {

// Up to 100 photos one self-contained page: no network, no script, pictures inside. For more, or
// where that page would become too large to be mailed, each photo has a page of its own in the
// folder report_photos, and long lists of photos are divided. Returns the first page's path. Throws
// InputError where it cannot be written.
std::string WriteReport(const BlockRecord& block, const BlockVerdict& verdict);

// The same from what lies in `directory`; see ReadBlockRecord and Judge.
std::string WriteReport(const std::string& directory);

}  // namespace orient
