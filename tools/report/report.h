// report.html: what a person looks at to decide whether to trust a block.
#pragma once

#include <string>

#include "tools/report/block_record.h"

namespace orient {

// One self-contained page: no network, no script, pictures inside. Returns its path. Throws
// InputError where it cannot be written.
std::string WriteReport(const BlockRecord& block);

// The same from what lies in `directory`; see ReadBlockRecord.
std::string WriteReport(const std::string& directory);

}  // namespace orient
