// Residual vectors of one photo over its frame.
#pragma once

#include "core/files/results.h"
#include "tools/report/template.h"

namespace orient {

// A <figure> with an inline SVG in pixel axes (col right, row down): arrows measured - computed
// from each patch's pixel, exaggerated by a stated round factor; patches that were not found at
// their predicted pixel. `width`, `height` [px] of the scan; 0 where unknown, then the patches'
// extent stands in. Empty where there is nothing to draw.
Markup ResidualPlot(const ExteriorResult& result, int width, int height);

}  // namespace orient
