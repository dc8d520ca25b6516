// The report's first page: figures of the whole block, what to look at first, all photos.
#pragma once

#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

Markup SummarySection(const BlockRecord& block, const BlockVerdict& verdict);
Markup ConcernsSection(const BlockRecord& block, const BlockVerdict& verdict);
Markup PhotosSection(const BlockRecord& block, const BlockVerdict& verdict);

}  // namespace orient
