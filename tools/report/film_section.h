// The report's part about the film.
#pragma once

#include "tools/report/block_record.h"
#include "tools/report/template.h"

namespace orient {

// How the film lies against its calibrated marks, in a table for each camera and pixel size. Empty
// without film.
Markup FilmSection(const BlockRecord& block);

}  // namespace orient
