// Whether two chips show one thing.
#pragma once

#include "patchdb/store/patch.h"

namespace orient::patchdb {

// Largest correlation of two chips in one CRS, each put where its own ground point says, over
// shifts of up to `search_px` pixels of the coarser one; of the middle that both cover. 0 where
// there is too little of that, or no contrast.
double BestCorrelation(const Patch& a, const Patch& b, int search_px);

}  // namespace orient::patchdb
