// The report's first page: figures of the whole block, what to look at first, all photos.
#pragma once

#include <functional>
#include <string>

#include "tools/report/photo_links.h"
#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

Markup SummarySection(const BlockRecord& block, const BlockVerdict& verdict,
                      const PhotoLinks& links);
// At most 200 photos, and a note of how many more there are.
Markup ConcernsSection(const BlockRecord& block, const BlockVerdict& verdict,
                       const PhotoLinks& links);

// The photos `begin` to `end` (not included) of the block.
struct PhotoRows {
  std::size_t begin = 0, end = 0;
  std::function<std::string(std::size_t)> href;  // of a photo's own part
  Markup pages;                                  // links to the other rows
};
Markup PhotosSection(const BlockRecord& block, const BlockVerdict& verdict, const PhotoRows& rows);

}  // namespace orient
