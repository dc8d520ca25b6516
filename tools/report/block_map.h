// The block's map: footprints, projection centres and patches on the ground, north up.
#pragma once

#include "tools/report/photo_links.h"
#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

// A <figure> with an inline SVG, legend and what could not be drawn. Failed photos do not decide
// the map's extent: a wrong pose may lie anywhere. Says so where no photo has a place.
Markup BlockMap(const BlockRecord& block, const BlockVerdict& verdict, const PhotoLinks& links);

}  // namespace orient
