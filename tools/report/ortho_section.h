// The report's part about orthophotos: of the run of `orient ortho`, and the quicklook.
#pragma once

#include "tools/report/block_record.h"
#include "tools/report/photo_section.h"
#include "tools/report/template.h"

namespace orient {

// GSD and CE90 of each orthophoto, the mosaic small, its seamlines, and the pictures of `orient
// block --quicklook`. Empty where there is nothing of it.
Markup OrthophotoSection(const BlockRecord& block, const PictureHtml& figure);

}  // namespace orient
