// How many photos show each place of the block.
#pragma once

#include <optional>

#include "tools/report/figures/overlap_figures.h"
#include "tools/report/template.h"
#include "tools/report/verdict.h"

namespace orient {

// Of the footprints of photos that are ok or weak; empty where fewer than two of them have one.
std::optional<OverlapCounts> CountOverlap(const BlockRecord& block, const BlockVerdict& verdict);

// A <figure> with an inline SVG of the ground in cells, by the number of footprints of ok and weak
// photos that cover a cell's middle, and the share of the covered ground for each number. Empty
// where fewer than two photos have a footprint.
Markup OverlapMap(const BlockRecord& block, const BlockVerdict& verdict);

}  // namespace orient
