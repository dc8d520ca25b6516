// The report's first page: figures of the whole block, what to look at first, all photos.
#pragma once

#include <string>

#include "tools/report/verdict.h"

namespace orient {

std::string SummarySection(const BlockRecord& block, const BlockVerdict& verdict);
std::string ConcernsSection(const BlockRecord& block, const BlockVerdict& verdict);
std::string PhotosSection(const BlockRecord& block, const BlockVerdict& verdict);

}  // namespace orient
